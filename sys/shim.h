/* What differs between Embree 3.13 and 4.x, behind one set of names.
 *
 * bindgen reads this file, so Rust and C share one declaration of every structure that crosses the border.
 * Units: as Embree's, lengths in the scene's unit, t in multiples of the ray's direction. */
#ifndef PDE_SHIM_H
#define PDE_SHIM_H

#include <stdbool.h>
#include <stddef.h>

/* build.rs may force a major version; otherwise the newer of the installed headers is taken. */
#if defined(PDE_EMBREE_MAJOR) && PDE_EMBREE_MAJOR == 3
#  include <embree3/rtcore.h>
#elif defined(PDE_EMBREE_MAJOR) && PDE_EMBREE_MAJOR == 4
#  include <embree4/rtcore.h>
#elif __has_include(<embree4/rtcore.h>)
#  include <embree4/rtcore.h>
#else
#  include <embree3/rtcore.h>
#endif

/* RTC_INVALID_GEOMETRY_ID as a constant that bindgen can evaluate. */
static const unsigned int PDE_INVALID_ID = RTC_INVALID_GEOMETRY_ID;

/* RTCRayHit as Embree >= 4.3 writes it (96 bytes), whatever the header's age.
 * Embree 4.3 appended instPrimID to RTCHit: a structure of the older 80 bytes is overrun on every hit,
 * while an older library leaves the last field of this one alone. */
struct RTC_ALIGN(16) PdeRayHit
{
  float org[3];
  float t_near;
  float dir[3];
  float time;
  float t_far;
  unsigned int mask;
  unsigned int id;
  unsigned int flags;
  float ng[3];
  float u;
  float v;
  unsigned int prim_id;
  unsigned int geom_id;
  unsigned int inst_id;
  unsigned int inst_prim_id;
};

/* The same ray in f64, read by the callbacks of user geometries, and the best of their hits so far. */
struct PdeRecord
{
  double org[3];
  double dir[3];
  double t_near;
  double time;
  /* Before a hit the ray's own end, after it the hit's t. */
  double t_far;
  double u;
  double v;
  /* PDE_INVALID_ID until a user hit is accepted. */
  unsigned int geom_id;
  unsigned int prim_id;
  /* The geometry's own number of what was hit in its primitive. */
  unsigned int part;
  /* The f32 end that Embree gets after an accepted hit. */
  float t_far_f32;
};

/* What an RTCGeometry of type USER points to. Immutable from commit until the geometry is gone. */
struct PdeUser
{
  void* object;
  void (*bounds)(const void* object, unsigned int prim, struct RTCBounds* out);
  /* Accepts a hit within [t_near, min(t_far, record->t_far)] and then returns true;
   * writes the record only if `keep` (nearest-hit queries). */
  bool (*intersect)(const void* object, unsigned int prim, unsigned int geom, float t_far, bool keep,
                    struct PdeRecord* record);
};

/* Nearest hit. `record` may be read and written by callbacks during the call only. */
void pde_intersect1(RTCScene scene, struct PdeRayHit* rayhit, struct PdeRecord* record);

/* Any hit: sets rayhit->t_far to -inf where there is one. The hit part is not touched. */
void pde_occluded1(RTCScene scene, struct PdeRayHit* rayhit, struct PdeRecord* record);

/* Installs the callbacks of a user geometry; `user` must outlive every scene that holds the geometry. */
void pde_set_user(RTCGeometry geometry, struct PdeUser* user, unsigned int primitives);

/* sizeof(struct RTCRayHit) as the header has it: 80 before Embree 4.3, 96 from there on. */
size_t pde_header_ray_hit_size(void);

#endif
