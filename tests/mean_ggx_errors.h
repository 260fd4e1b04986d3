/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of the mean of a GGX lobe over a cap against quadrature, over viewers spread about the direction that the lobe
 * mirrors to the cap's middle; relative to the integral's largest value over those viewers. */
#ifndef TESTS_MEAN_GGX_ERRORS_H
#define TESTS_MEAN_GGX_ERRORS_H

#include "eas/ggx.h"
#include "eas/mean_brdf.h"
#include "tests/caps.h"

struct errors {
    float rms, most;
};

/* A white metal (F = 1), or one whose reflectance rises from .04 to 1 as (1-c)^5; its tangent turned from the cap's
 * azimuth. */
static inline struct lobe ggx_lobe(float roughness, float anisotropic, float turned, bool white)
{
    float2 alpha = ggx_alphas(roughness, anisotropic);
    float f0 = white ? 1 : .04f;
    return (struct lobe){.type = LOBE_METAL,
                         .weight = {1, 1, 1},
                         .alpha_x = alpha.x,
                         .alpha_y = alpha.y,
                         .tangent = direction(0, turned),
                         .f0 = {f0, f0, f0},
                         .f82 = {1, 1, 1}};
}

/* Viewers are at least least_up over the horizon, rad. */
static inline struct errors errors_of(const struct lobe *lobe, struct cap cap, float least_up)
{
    enum { UPS = 6, SIDES = 4 };
    const float3 n = {0, 0, 1};
    float theta = acosf(1 - cap.omega * (1 / (2 * PI))), elevation = asinf(cap.axis.z), largest = 0;
    float spread = theta + 2 * sqrtf(lobe->alpha_x * lobe->alpha_y);
    /* Steps narrow enough for the cap and for the lobe's narrow side. */
    int steps = 32 + (int)(8 * theta / minf(lobe->alpha_x, lobe->alpha_y)), count = 0;
    struct errors errors = {0, 0};
    for (int i = -UPS; i <= UPS; i++)
        for (int j = 0; j <= SIDES; j++) {
            float up = elevation + spread * (float)i / UPS;
            if (up < least_up || up > PI / 2) continue;
            float3 wo = direction(up, PI + minf(spread * (float)j / (SIDES * cosf(minf(up, 1.4f))), PI));
            struct mean_ggx mean = mean_ggx(lobe, n, wo);
            rgb value;
            mean_ggx_caps(&mean, &cap, 1, &value);
            float exact = mean_lobe_quadrature(lobe, n, wo, cap, steps, steps).x, error = fabsf(value.x - exact);
            largest = maxf(largest, exact);
            errors.most = error <= errors.most ? errors.most : error; /* no number is an error */
            errors.rms += sqr(error);
            count++;
        }
    if (count == 0) return errors;
    return (struct errors){sqrtf(errors.rms / (float)count) / largest, errors.most / largest};
}

#endif
