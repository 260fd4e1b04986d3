/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace.h"

#include <embree3/rtcore.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Threads whose counters stand on cache lines of their own. */
enum { COUNTERS = 1024 };

/* Bits of Embree's masks: the rays that meet an object. */
enum { RAY_CAMERA = 1, RAY_SHADOW = 2, RAY_OTHER = 4, RAY_ANY = 7 };

struct counter {
    _Alignas(64) uint64_t rays;
};

/* A shared mesh's own BVH. */
struct shared {
    const struct triangles *triangles;
    RTCScene scene;
};

struct trace {
    RTCDevice device;
    RTCScene scene;
    struct shared *shared;
    uint32_t shared_count;
    struct counter *counters;
};

/* Vertices are copied: Embree reads 16 bytes of each, past the end of the borrowed array's last one. */
static RTCGeometry triangle_geometry(RTCDevice device, const struct triangles *t)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    size_t bytes = 3 * sizeof(float);
    void *vertices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, bytes, t->vertex_count);
    if (vertices) memcpy(vertices, t->positions, bytes * t->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->indices, 0,
                               3 * sizeof(uint32_t), t->triangle_count);
    rtcSetGeometryMask(geometry, RAY_ANY);
    rtcCommitGeometry(geometry);
    return geometry;
}

static RTCScene robust_scene(RTCDevice device)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    return scene;
}

/* The BVH of a shared mesh, built at its first use. */
static RTCScene shared_scene(struct trace *trace, const struct triangles *triangles)
{
    for (uint32_t i = trace->shared_count; i-- > 0;)
        if (trace->shared[i].triangles == triangles) return trace->shared[i].scene;
    RTCScene scene = robust_scene(trace->device);
    RTCGeometry geometry = triangle_geometry(trace->device, triangles);
    rtcAttachGeometryByID(scene, geometry, 0);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    trace->shared[trace->shared_count++] = (struct shared){triangles, scene};
    return scene;
}

static RTCGeometry instance_geometry(struct trace *trace, const struct trace_object *object)
{
    RTCGeometry geometry = rtcNewGeometry(trace->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, shared_scene(trace, object->triangles));
    rtcSetGeometryTimeStepCount(geometry, 1);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, object->transform);
    rtcCommitGeometry(geometry);
    return geometry;
}

struct trace *trace_build(const struct trace_object *objects, uint32_t count, char error[static SCENE_ERROR])
{
    struct trace *trace = calloc(1, sizeof *trace);
    if (trace) {
        trace->shared = calloc(count + 1, sizeof *trace->shared);
        trace->counters = aligned_alloc(64, COUNTERS * sizeof *trace->counters);
        trace->device = rtcNewDevice("threads=1");
    }
    if (!trace || !trace->shared || !trace->counters || !trace->device) {
        snprintf(error, SCENE_ERROR, "not enough memory for Embree");
        trace_free(trace);
        return NULL;
    }
    memset(trace->counters, 0, COUNTERS * sizeof *trace->counters);
    trace->scene = robust_scene(trace->device);
    for (uint32_t i = 0; i < count; i++) {
        RTCGeometry geometry = objects[i].instanced ? instance_geometry(trace, &objects[i])
                                                    : triangle_geometry(trace->device, objects[i].triangles);
        rtcSetGeometryMask(geometry, (unsigned)(RAY_ANY & ~(objects[i].hidden ? RAY_CAMERA : 0) &
                                                ~(objects[i].shadowless ? RAY_SHADOW : 0)));
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(trace->scene, geometry, i);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(trace->scene);
    enum RTCError code = rtcGetDeviceError(trace->device);
    if (code != RTC_ERROR_NONE) {
        if (code == RTC_ERROR_OUT_OF_MEMORY)
            snprintf(error, SCENE_ERROR, "not enough memory for the BVH of %u objects", count);
        else snprintf(error, SCENE_ERROR, "Embree could not build the BVH (its error %d)", (int)code);
        trace_free(trace);
        return NULL;
    }
    return trace;
}

void trace_free(struct trace *trace)
{
    if (!trace) return;
    if (trace->scene) rtcReleaseScene(trace->scene);
    for (uint32_t i = 0; i < trace->shared_count; i++) rtcReleaseScene(trace->shared[i].scene);
    if (trace->device) rtcReleaseDevice(trace->device);
    free(trace->shared);
    free(trace->counters);
    free(trace);
}

static inline void count_ray(const struct trace *trace)
{
    trace->counters[omp_get_thread_num() & (COUNTERS - 1)].rays++;
}

static struct RTCRay make_ray(float3 origin, float3 dir, float tfar, unsigned mask)
{
    return (struct RTCRay){.org_x = origin.x,
                           .org_y = origin.y,
                           .org_z = origin.z,
                           .dir_x = dir.x,
                           .dir_y = dir.y,
                           .dir_z = dir.z,
                           .tfar = tfar,
                           .mask = mask};
}

static inline bool closest(const struct trace *trace, unsigned mask, float3 origin, float3 dir, float tfar,
                           struct hit *hit)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit r = {.ray = make_ray(origin, dir, tfar, mask),
                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    count_ray(trace);
    rtcIntersect1(trace->scene, &context, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    uint32_t object = r.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? r.hit.instID[0] : r.hit.geomID;
    *hit = (struct hit){r.ray.tfar, object, r.hit.primID, r.hit.u, r.hit.v};
    return true;
}

bool trace_closest(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit)
{
    return closest(trace, RAY_OTHER, origin, dir, tfar, hit);
}

bool trace_camera(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit)
{
    return closest(trace, RAY_CAMERA, origin, dir, tfar, hit);
}

bool trace_caster(const struct trace *trace, float3 origin, float3 dir, float tfar, struct hit *hit)
{
    return closest(trace, RAY_SHADOW, origin, dir, tfar, hit);
}

bool trace_occluded(const struct trace *trace, float3 origin, float3 dir, float tfar)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = make_ray(origin, dir, tfar, RAY_SHADOW);
    count_ray(trace);
    rtcOccluded1(trace->scene, &context, &ray);
    return ray.tfar < 0;
}

void trace_shadows(const struct trace *trace, const struct shadow_ray *rays, int count, bool *occluded)
{
    enum { PACKET = 16 };
    struct RTCIntersectContext context;
    /* Not flagged coherent, which brings no speed here: Embree 3.13's occlusion by frusta never ends for some
     * packets. */
    rtcInitIntersectContext(&context);
    trace->counters[omp_get_thread_num() & (COUNTERS - 1)].rays += (uint64_t)count;
    for (int first = 0; first < count; first += PACKET) {
        const struct shadow_ray *r = rays + first;
        struct RTCRay16 packet;
        _Alignas(64) int valid[PACKET];
        int last = count - first - 1;
        for (int i = 0; i < PACKET; i++) {
            int k = i < last ? i : last;
            valid[i] = i <= last ? -1 : 0;
            packet.org_x[i] = r[k].origin.x;
            packet.org_y[i] = r[k].origin.y;
            packet.org_z[i] = r[k].origin.z;
            packet.dir_x[i] = r[k].dir.x;
            packet.dir_y[i] = r[k].dir.y;
            packet.dir_z[i] = r[k].dir.z;
            packet.tnear[i] = packet.time[i] = 0;
            packet.tfar[i] = r[k].tfar;
            packet.mask[i] = RAY_SHADOW;
            packet.flags[i] = 0;
        }
        rtcOccluded16(valid, trace->scene, &context, &packet);
        for (int i = 0; i < PACKET && first + i < count; i++) occluded[first + i] = packet.tfar[i] < 0;
    }
}

/* One coordinate, moved by 64 ulps along n (a quarter of the chapter's: of random triangles up to 50 m, instanced ones
 * too, at most 1e-4 of the rays still hit their own); near the origin, where ulps vanish, by n / 2^18 of `unit`. */
static inline float offset_coordinate(float p, float n, float unit)
{
    if (fabsf(p) < unit / 32) return p + n * unit * 0x1p-18f;
    int32_t bits;
    memcpy(&bits, &p, sizeof bits);
    int32_t steps = (int32_t)(64 * n);
    bits += p < 0 ? -steps : steps;
    memcpy(&p, &bits, sizeof p);
    return p;
}

float3 trace_offset(float3 p, float3 ng, float radius)
{
    float unit = minf(radius, 1);
    return vec3(offset_coordinate(p.x, ng.x, unit), offset_coordinate(p.y, ng.y, unit),
                offset_coordinate(p.z, ng.z, unit));
}

float trace_radius(const struct trace *trace)
{
    struct RTCBounds b;
    rtcGetSceneBounds(trace->scene, &b);
    return b.upper_x >= b.lower_x
               ? length(vec3(b.upper_x - b.lower_x, b.upper_y - b.lower_y, b.upper_z - b.lower_z)) / 2
               : 0;
}

uint64_t trace_rays(const struct trace *trace)
{
    uint64_t rays = 0;
    for (int i = 0; i < COUNTERS; i++) rays += trace->counters[i].rays;
    return rays;
}
