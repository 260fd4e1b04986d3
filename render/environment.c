/* SPDX-License-Identifier: Apache-2.0 */
#include "render/environment.h"

#include <stdlib.h>

#include "render/transform.h"

#define THRESHOLD_FACTOR 2 /* times the mean luminance */

enum { GUIDED = 8 }; /* cumulative chances to a guide */

static inline float2 direction_uv(const struct environment *e, float3 dir)
{
    float x = dot(dir, e->axes[0]), y = dot(dir, e->axes[1]), z = dot(dir, e->axes[2]);
    return (float2){0.5f - atan2f(y, x) / (2 * PI), 0.5f + asinf(clampf(z, -1, 1)) / PI};
}

static inline rgb texel(const struct environment *e, int x, int y)
{
    const struct image *image = e->image;
    x = x < 0 ? x + image->width : x >= image->width ? x - image->width : x;
    y = y < 0 ? 0 : y >= image->height ? image->height - 1 : y;
    const float *p = image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channel_count;
    rgb c = image->channel_count < 3 ? vec3(p[0], p[0], p[0]) : vec_from(p);
    return mul(c, e->radiance);
}

/* x, y: texels from the picture's upper left. */
static rgb radiance_at(const struct environment *e, float x, float y)
{
    if (e->closest) return texel(e, (int)floorf(x), (int)floorf(y));
    float fx = floorf(x - 0.5f), fy = floorf(y - 0.5f), s = x - 0.5f - fx, t = y - 0.5f - fy;
    int ix = (int)fx, iy = (int)fy;
    return lerp3(lerp3(texel(e, ix, iy), texel(e, ix + 1, iy), s),
                 lerp3(texel(e, ix, iy + 1), texel(e, ix + 1, iy + 1), s), t);
}

static rgb radiance(const struct environment *e, float3 dir)
{
    if (!e->image) return e->radiance;
    float2 uv = direction_uv(e, dir);
    return radiance_at(e, uv.x * (float)e->image->width, (1 - uv.y) * (float)e->image->height);
}

static inline rgb strong_of(const struct environment *e, rgb c)
{
    return vec3(maxf(c.x - e->threshold, 0), maxf(c.y - e->threshold, 0), maxf(c.z - e->threshold, 0));
}

/* Sine of the latitude down row y, t in [0, 1] uniform in solid angle. */
static inline float sine_down(const struct environment *e, int y, float t)
{
    return e->tops[y] + t * (e->tops[y + 1] - e->tops[y]);
}

/* Solid angle of a texel of row y, sr. */
static inline float texel_angle(const struct environment *e, int y)
{
    return 2 * PI / (float)e->image->width * (e->tops[y] - e->tops[y + 1]);
}

/* The direction of a point of texel (x, y): s along the row; t down it, uniform in solid angle. */
static float3 texel_direction(const struct environment *e, int x, int y, float s, float t)
{
    float z = sine_down(e, y, t), r = sqrtf(maxf(1 - z * z, 0));
    float phi = (0.5f - ((float)x + s) / (float)e->image->width) * 2 * PI;
    return mad(mad(scale(e->axes[0], r * cosf(phi)), e->axes[1], r * sinf(phi)), e->axes[2], z);
}

/* Luminance of the strong part over the cell of texel (x, y), by what bilinear look-up mixes there: positive wherever
 * that look-up can find anything strong, since it spreads each texel by one. */
static float cell_strength(const struct environment *e, int x, int y)
{
    static const float share[3] = {0.125f, 0.75f, 0.125f};
    float sum = 0;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++)
            sum += share[i + 1] * share[j + 1] * luminance(strong_of(e, texel(e, x + i, y + j)));
    return sum;
}

static float mean_luminance(const struct environment *e)
{
    double sum = 0;
    for (int y = 0; y < e->image->height; y++) {
        double row = 0;
        for (int x = 0; x < e->image->width; x++) row += luminance(texel(e, x, y));
        sum += row * texel_angle(e, y);
    }
    return (float)(sum / (4 * PI));
}

/* Guides to `count` chances: a power of two, so that dividing [0, 1) among them is exact. */
static int guides_for(int count)
{
    int guides = 1;
    while (guides * GUIDED < count) guides *= 2;
    return guides;
}

/* guide[k]: the last chance that is at most k / guides. */
static void make_guide(const float *cumulative, int count, int guides, uint32_t *guide)
{
    int at = 0;
    for (int k = 0; k <= guides; k++) {
        while (at < count - 1 && cumulative[at + 1] <= (float)k / (float)guides) at++;
        guide[k] = (uint32_t)at;
    }
}

static float *columns_of(const struct environment *e, int y)
{
    return e->columns + (size_t)y * ((size_t)e->image->width + 1);
}

static uint32_t *column_guide(const struct environment *e, int y)
{
    return e->column_guide + (size_t)y * ((size_t)e->column_guides + 1);
}

/* The cumulative chances of texels by strength times solid angle; the sum over the sphere is the strong flux. */
static void accumulate(struct environment *e)
{
    int w = e->image->width, h = e->image->height;
    double total = 0;
    for (int y = 0; y < h; y++) {
        float *columns = columns_of(e, y);
        double row = 0;
        columns[0] = 0;
        for (int x = 0; x < w; x++) columns[x + 1] = (float)(row += cell_strength(e, x, y));
        for (int x = 1; x <= w && row > 0; x++) columns[x] /= (float)row;
        make_guide(columns, w, e->column_guides, column_guide(e, y));
        e->rows[y] = (float)total;
        total += row * texel_angle(e, y);
    }
    e->rows[h] = (float)total;
    for (int y = 0; y <= h && total > 0; y++) e->rows[y] /= (float)total;
    make_guide(e->rows, h, e->row_guides, e->row_guide);
    e->strong_flux = (float)total;
}

bool environment_build(const struct scene_world *world, const struct textures *textures,
                       struct environment *environment)
{
    struct environment *e = environment;
    *e = (struct environment){.radiance = vec_from(world->radiance), .threshold = INFINITY};
    if (world->texture == SCENE_NONE || is_black(e->radiance)) return true;
    const struct scene_texture *texture = &textures->scene->textures[world->texture];
    e->image = &textures->images[texture->image];
    e->closest = texture->interpolation == TEXTURE_CLOSEST;
    for (int i = 0; i < 3; i++) e->axes[i] = normalize(transform_column(world->transform, i));
    size_t w = (size_t)e->image->width, h = (size_t)e->image->height;
    e->rows = malloc((h + 1) * sizeof *e->rows);
    e->columns = malloc((w + 1) * h * sizeof *e->columns);
    e->row_guides = guides_for((int)h);
    e->column_guides = guides_for((int)w);
    e->row_guide = malloc(((size_t)e->row_guides + 1) * sizeof *e->row_guide);
    e->column_guide = malloc(((size_t)e->column_guides + 1) * h * sizeof *e->column_guide);
    e->tops = malloc((h + 1) * sizeof *e->tops);
    if (!e->rows || !e->columns || !e->row_guide || !e->column_guide || !e->tops) {
        environment_free(e);
        return false;
    }
    for (size_t y = 0; y <= h; y++) e->tops[y] = cosf(PI * (float)y / (float)h);
    e->threshold = THRESHOLD_FACTOR * mean_luminance(e);
    accumulate(e);
    return true;
}

void environment_free(struct environment *environment)
{
    free(environment->rows);
    free(environment->columns);
    free(environment->row_guide);
    free(environment->column_guide);
    free(environment->tops);
    *environment = (struct environment){0};
}

rgb environment_strong(const struct environment *environment, float3 dir)
{
    return environment->strong_flux > 0 ? strong_of(environment, radiance(environment, dir)) : (rgb){0};
}

rgb environment_rest(const struct environment *environment, float3 dir)
{
    rgb c = radiance(environment, dir);
    float t = environment->strong_flux > 0 ? environment->threshold : INFINITY;
    return vec3(minf(c.x, t), minf(c.y, t), minf(c.z, t));
}

/* The i with cumulative[i] <= u < cumulative[i + 1], and in *fraction where between them. */
static int find(const float *cumulative, const uint32_t *guide, int guides, float u, float *fraction)
{
    int k = (int)(u * (float)guides);
    if (k == guides) k--; /* rounding */
    int low = (int)guide[k], high = (int)guide[k + 1] + 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (cumulative[middle] <= u) low = middle;
        else high = middle;
    }
    float width = cumulative[low + 1] - cumulative[low];
    *fraction = width > 0 ? clampf((u - cumulative[low]) / width, 0, 1) : 0.5f;
    return low;
}

static float texel_pdf(const struct environment *e, int x, int y)
{
    const float *columns = columns_of(e, y);
    return (e->rows[y + 1] - e->rows[y]) * (columns[x + 1] - columns[x]) / texel_angle(e, y);
}

float3 environment_sample(const struct environment *environment, const float u[static 2], float *pdf, rgb *strong)
{
    const struct environment *e = environment;
    float s, t;
    int y = find(e->rows, e->row_guide, e->row_guides, u[0], &t);
    int x = find(columns_of(e, y), column_guide(e, y), e->column_guides, u[1], &s);
    *pdf = texel_pdf(e, x, y);
    float latitude = asinf(sine_down(e, y, t));
    *strong = strong_of(e, radiance_at(e, (float)x + s, (.5f - latitude / PI) * (float)e->image->height));
    return texel_direction(e, x, y, s, t);
}

float environment_pdf(const struct environment *environment, float3 dir)
{
    const struct environment *e = environment;
    if (!(e->strong_flux > 0)) return 0;
    float2 uv = direction_uv(e, dir);
    int x = (int)(uv.x * (float)e->image->width), y = (int)((1 - uv.y) * (float)e->image->height);
    x = x < 0 ? 0 : x >= e->image->width ? e->image->width - 1 : x;
    y = y < 0 ? 0 : y >= e->image->height ? e->image->height - 1 : y;
    return texel_pdf(e, x, y);
}

/* A texel's strong light. */
struct texel_flux {
    int x, y;
    float3 dir;
    rgb flux;
};

/* A group of texels and how much light it blurs how far: flux x variance of the directions. */
struct group {
    struct texel_flux *first;
    size_t count;
    float3 mean; /* of the directions, by flux */
    rgb flux;
    float blur;
};

static struct group group_of(struct texel_flux *first, size_t count)
{
    struct group g = {.first = first, .count = count};
    double sum = 0, mean[3] = {0}, flux[3] = {0};
    for (size_t i = 0; i < count; i++) {
        const struct texel_flux *t = &first[i];
        double y = luminance(t->flux), f[3] = {t->flux.x, t->flux.y, t->flux.z}, d[3] = {t->dir.x, t->dir.y, t->dir.z};
        sum += y;
        for (int k = 0; k < 3; k++) {
            mean[k] += d[k] * y;
            flux[k] += f[k];
        }
    }
    g.flux = vec3((float)flux[0], (float)flux[1], (float)flux[2]);
    g.mean = vec3((float)(mean[0] / sum), (float)(mean[1] / sum), (float)(mean[2] / sum));
    /* The directions are unit: their variance is 1 - |mean|^2. One texel can't be halved. */
    g.blur = count > 1 ? (float)sum * maxf(1 - dot(g.mean, g.mean), 0) : 0;
    return g;
}

/* Halves a group at the mean of the coordinate that varies most; both halves keep some texels. */
static void halve(struct group *group, struct group *other)
{
    double variance[3] = {0};
    for (size_t i = 0; i < group->count; i++) {
        float3 d = sub(group->first[i].dir, group->mean);
        float y = luminance(group->first[i].flux);
        variance[0] += d.x * d.x * y;
        variance[1] += d.y * d.y * y;
        variance[2] += d.z * d.z * y;
    }
    float3 axis = variance[0] > variance[1] && variance[0] > variance[2] ? vec3(1, 0, 0)
                  : variance[1] > variance[2]                            ? vec3(0, 1, 0)
                                                                         : vec3(0, 0, 1);
    float at = dot(group->mean, axis);
    struct texel_flux *texels = group->first;
    size_t low = 0, high = group->count;
    while (low < high) {
        if (dot(texels[low].dir, axis) < at) {
            low++;
        } else {
            struct texel_flux swap = texels[low];
            texels[low] = texels[--high];
            texels[high] = swap;
        }
    }
    if (low == 0 || low == group->count) low = group->count / 2; /* equal but for rounding */
    *other = group_of(texels + low, group->count - low);
    *group = group_of(texels, low);
}

/* Halves lie side by side in the array of texels. */
static int by_place(const void *a, const void *b)
{
    const struct group *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

/* Texels side by side into places side by side: halves of halves. The loop takes the larger half: few levels. */
static void sort_texels(struct group group)
{
    while (group.count > 1) {
        struct group other;
        halve(&group, &other);
        bool swap = other.count > group.count;
        sort_texels(swap ? group : other);
        if (swap) group = other;
    }
}

/* Each place stands for as much light; those in one texel are spread over it. */
static void find_places(const struct environment *e, const struct group *group, float3 places[ENVIRONMENT_PLACES])
{
    sort_texels(*group);
    double sum = 0, step = 0, passed = 0;
    for (size_t i = 0; i < group->count; i++) sum += luminance(group->first[i].flux);
    step = sum / ENVIRONMENT_PLACES;
    size_t i = 0;
    for (int k = 0; k < ENVIRONMENT_PLACES; k++) {
        double at = (k + .5) * step;
        while (i + 1 < group->count && passed + luminance(group->first[i].flux) <= at)
            passed += luminance(group->first[i++].flux);
        float s = fmodf((float)k * .7548777f, 1), t = fmodf((float)k * .5698403f, 1); /* Roberts' R2 sequence */
        places[k] = texel_direction(e, group->first[i].x, group->first[i].y, s, t);
    }
}

int environment_cells(const struct environment *environment, int most, struct environment_cell *cells,
                      float3 *places)
{
    const struct environment *e = environment;
    if (!(e->strong_flux > 0)) return 0;
    enum { SIDE = 4 }; /* squared: look-ups a texel */
    struct texel_flux *texels = malloc((size_t)e->image->width * (size_t)e->image->height * sizeof *texels);
    struct group *groups = malloc((size_t)most * sizeof *groups);
    size_t texel_count = 0;
    int count = 0;
    for (int y = 0; texels && groups && y < e->image->height; y++)
        for (int x = 0; x < e->image->width; x++) {
            if (!(cell_strength(e, x, y) > 0)) continue;
            struct texel_flux t = {.x = x, .y = y};
            for (int k = 0; k < SIDE * SIDE; k++) {
                float3 dir =
                    texel_direction(e, x, y, ((float)(k % SIDE) + .5f) / SIDE, ((float)(k / SIDE) + .5f) / SIDE);
                t.dir = add(t.dir, dir);
                t.flux = mad(t.flux, environment_strong(e, dir), texel_angle(e, y) / (SIDE * SIDE));
            }
            t.dir = normalize(t.dir);
            if (luminance(t.flux) > 0) texels[texel_count++] = t;
        }
    if (texel_count) groups[count++] = group_of(texels, texel_count);
    while (count && count < most) {
        int worst = 0;
        for (int i = 1; i < count; i++)
            if (groups[i].blur > groups[worst].blur) worst = i;
        if (!(groups[worst].blur > 0)) break;
        halve(&groups[worst], &groups[count++]);
    }
    if (count > 0) qsort(groups, (size_t)count, sizeof *groups, by_place);
    for (int i = 0; i < count; i++) {
        cells[i] =
            (struct environment_cell){groups[i].flux, normalize(groups[i].mean), minf(length(groups[i].mean), 1)};
        find_places(e, &groups[i], places + i * ENVIRONMENT_PLACES);
    }
    bool ok = texels && groups;
    free(texels);
    free(groups);
    return ok ? count : -1;
}
