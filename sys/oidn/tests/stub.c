/* Stands in for Open Image Denoise: "denoises" by averaging colour and albedo, and checks that what it is given fits. */
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

typedef struct { const char* error; int live_filters; } Device;
typedef struct { Device* device; float* image[4]; size_t width, height; bool hdr, committed; } Filter;

static Device the_device;
static Filter the_filter;

Device* oidnNewDevice(int type) { memset(&the_device, 0, sizeof the_device); return type == 1 ? &the_device : NULL; }
void oidnCommitDevice(Device* device) { (void)device; }
void oidnReleaseDevice(Device* device) { if (device->live_filters) __builtin_trap(); }

int oidnGetDeviceError(Device* device, const char** message) {
    if (!device) { *message = "no such device"; return 1; }
    if (!device->error) return 0;
    *message = device->error;
    device->error = NULL;
    return 2;
}

Filter* oidnNewFilter(Device* device, const char* type) {
    if (strcmp(type, "RT")) return NULL;
    memset(&the_filter, 0, sizeof the_filter);
    the_filter.device = device;
    device->live_filters++;
    return &the_filter;
}

void oidnReleaseFilter(Filter* filter) { filter->device->live_filters--; }

void oidnSetSharedFilterImage(Filter* filter, const char* name, void* pixels, int format, size_t width, size_t height,
                              size_t offset, size_t pixel_stride, size_t row_stride) {
    static const char* names[4] = {"color", "albedo", "normal", "output"};
    if (format != 3 || offset || pixel_stride || row_stride) filter->device->error = "not packed floats";
    for (int i = 0; i < 4; i++)
        if (!strcmp(name, names[i])) filter->image[i] = pixels;
    filter->width = width;
    filter->height = height;
}

void SET_FLAG(Filter* filter, const char* name, bool value) { if (!strcmp(name, "hdr")) filter->hdr = value; }
void oidnCommitFilter(Filter* filter) { filter->committed = true; }

void oidnExecuteFilter(Filter* filter) {
    if (!filter->hdr || !filter->committed || !filter->image[0] || !filter->image[3]) {
        filter->device->error = "not ready";
        return;
    }
    for (size_t i = 0; i < 3 * filter->width * filter->height; i++) {
        if (filter->image[0][i] < 0) filter->device->error = "negative light";
        filter->image[3][i] = filter->image[1] ? (filter->image[0][i] + filter->image[1][i]) / 2 : filter->image[0][i] * 2;
    }
}
