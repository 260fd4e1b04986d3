/* SPDX-License-Identifier: Apache-2.0 */
#include "eas/beckmann.h"

enum { STEPS = 16 };

/* The slope below which a share u of the projected area lies, alpha 1, seen at an angle of that tangent: the root of a
 * cumulative function, by Newton's steps and, where they leave the bracket, bisection. */
static float slope_at(float tangent, float u)
{
    float k = tangent * .56418958f, high = tangent > .2f ? 1 / tangent : 5, low = -5; /* e^-25 is nothing */
    float goal = u * (1 + erff(high) + k * expf(-high * high)), x = minf(0, high);
    for (int i = 0; i < STEPS; i++) {
        float gauss = expf(-x * x), over = 1 + erff(x) + k * gauss - goal;
        if (over > 0) high = x;
        else low = x;
        float slope = 1.1283792f * gauss * (1 - x * tangent), next = x - over / maxf(slope, 1e-20f);
        if (!(next > low && next < high)) next = (low + high) / 2;
        if (fabsf(next - x) < 1e-6f) return next;
        x = next;
    }
    return x;
}

float3 beckmann_visible_normal(float alpha_x, float alpha_y, float3 w, const float u[static 2])
{
    float x = alpha_x * w.x, y = alpha_y * w.y, level = sqrtf(x * x + y * y);
    float c = level > 0 ? x / level : 1, s = level > 0 ? y / level : 0;
    float along = slope_at(level / w.z, u[0]), across = slope_at(0, u[1]);
    return normalize(vec3(-alpha_x * (c * along - s * across), -alpha_y * (s * along + c * across), 1));
}
