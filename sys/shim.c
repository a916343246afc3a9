/* The calls whose prototypes differ between Embree 3.13 and 4.x. See shim.h. */
#include "shim.h"

#include <stdlib.h>

/* ---- layout: ours against the header's, offset by offset ---- */

#define SAME(ours, theirs)                                                                       \
  _Static_assert(offsetof(struct PdeRayHit, ours) == offsetof(struct RTCRayHit, theirs),         \
                 "PdeRayHit." #ours " is not where this header has RTCRayHit." #theirs)
SAME(org, ray.org_x);
SAME(t_near, ray.tnear);
SAME(dir, ray.dir_x);
SAME(time, ray.time);
SAME(t_far, ray.tfar);
SAME(mask, ray.mask);
SAME(id, ray.id);
SAME(flags, ray.flags);
SAME(ng, hit.Ng_x);
SAME(u, hit.u);
SAME(v, hit.v);
SAME(prim_id, hit.primID);
SAME(geom_id, hit.geomID);
SAME(inst_id, hit.instID);
#if RTC_VERSION >= 40300
SAME(inst_prim_id, hit.instPrimID);
_Static_assert(sizeof(struct RTCRayHit) == 96, "Embree >= 4.3 writes 96 bytes");
#endif
_Static_assert(sizeof(struct PdeRayHit) == 96, "always the larger layout");
_Static_assert(sizeof(struct RTCRayHit) <= sizeof(struct PdeRayHit), "this Embree writes past our RTCRayHit");
_Static_assert(_Alignof(struct PdeRayHit) == 16, "Embree loads a ray with aligned instructions");
_Static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT == 1, "the layout holds one instance level");

/* ---- the context, extended by a pointer to the f64 record ---- */

#if RTC_VERSION_MAJOR == 3
typedef struct RTCIntersectContext EmbreeContext;
#  define INIT_CONTEXT rtcInitIntersectContext
#else
typedef struct RTCRayQueryContext EmbreeContext;
#  define INIT_CONTEXT rtcInitRayQueryContext
#endif

/* Embree hands the very pointer it was given to the callbacks, so what follows its context is ours. */
struct Extended
{
  EmbreeContext context;
  struct PdeRecord* record;
};
_Static_assert(offsetof(struct Extended, context) == 0, "a callback casts the context back");

static struct PdeRecord* record_of(EmbreeContext* context)
{
  return ((struct Extended*)context)->record;
}

void pde_intersect1(RTCScene scene, struct PdeRayHit* rayhit, struct PdeRecord* record)
{
  struct Extended extended;
  INIT_CONTEXT(&extended.context);
  extended.record = record;
#if RTC_VERSION_MAJOR == 3
  rtcIntersect1(scene, &extended.context, (struct RTCRayHit*)rayhit);
#else
  struct RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &extended.context;
  rtcIntersect1(scene, (struct RTCRayHit*)rayhit, &arguments);
#endif
}

void pde_occluded1(RTCScene scene, struct PdeRayHit* rayhit, struct PdeRecord* record)
{
  struct Extended extended;
  INIT_CONTEXT(&extended.context);
  extended.record = record;
#if RTC_VERSION_MAJOR == 3
  rtcOccluded1(scene, &extended.context, (struct RTCRay*)rayhit);
#else
  struct RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &extended.context;
  rtcOccluded1(scene, (struct RTCRay*)rayhit, &arguments);
#endif
}

/* ---- user geometries ---- */

/* Packets are never traced, so N is 1, and for N = 1 Embree's structures of arrays are the plain ones. */
static void require_single_ray(unsigned int n)
{
  if (n != 1)
    abort();
}

static void user_bounds(const struct RTCBoundsFunctionArguments* args)
{
  const struct PdeUser* user = (const struct PdeUser*)args->geometryUserPtr;
  user->bounds(user->object, args->primID, args->bounds_o);
}

static void user_intersect(const struct RTCIntersectFunctionNArguments* args)
{
  require_single_ray(args->N);
  if (!args->valid[0])
    return;
  const struct PdeUser* user = (const struct PdeUser*)args->geometryUserPtr;
  struct RTCRayHit* rayhit = (struct RTCRayHit*)args->rayhit;
  struct PdeRecord* record = record_of(args->context);
  if (!user->intersect(user->object, args->primID, args->geomID, rayhit->ray.tfar, true, record))
    return;
  if (record->t_far_f32 < rayhit->ray.tfar)
    rayhit->ray.tfar = record->t_far_f32;
  rayhit->hit.u = (float)record->u;
  rayhit->hit.v = (float)record->v;
  rayhit->hit.geomID = args->geomID;
  rayhit->hit.primID = args->primID;
  /* Top level only: no instance is on the stack, but an earlier hit may have left its own. */
  rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION >= 40300
  rayhit->hit.instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
#endif
}

static void user_occluded(const struct RTCOccludedFunctionNArguments* args)
{
  require_single_ray(args->N);
  if (!args->valid[0])
    return;
  const struct PdeUser* user = (const struct PdeUser*)args->geometryUserPtr;
  struct RTCRay* ray = (struct RTCRay*)args->ray;
  /* Not ray->tfar: it is rounded down for the triangles' sake, and nothing else shortens an any-hit ray. */
  if (user->intersect(user->object, args->primID, args->geomID, __builtin_inff(), false,
                      record_of(args->context)))
    ray->tfar = -__builtin_inff();
}

void pde_set_user(RTCGeometry geometry, struct PdeUser* user, unsigned int primitives)
{
  rtcSetGeometryUserPrimitiveCount(geometry, primitives);
  rtcSetGeometryUserData(geometry, user);
  rtcSetGeometryBoundsFunction(geometry, user_bounds, NULL);
  rtcSetGeometryIntersectFunction(geometry, user_intersect);
  rtcSetGeometryOccludedFunction(geometry, user_occluded);
}

size_t pde_header_ray_hit_size(void)
{
  return sizeof(struct RTCRayHit);
}
