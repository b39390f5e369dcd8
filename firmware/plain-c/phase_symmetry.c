#include "phase_symmetry.h"

#include <arm_math.h>
#include <math.h>

#define FORWARD 0
#define INVERSE 1

typedef struct {
    float re, im;
} cfloat;

/* A filter's gain is radial times angular: a table for each scale and each orientation. */
static float radial[SCALES][MAX_SIDE * MAX_SIDE];
static float angular[ORIENTATIONS][MAX_SIDE * MAX_SIDE];
static cfloat spectrum[MAX_SIDE * MAX_SIDE];
static cfloat filtered[MAX_SIDE * MAX_SIDE];
static cfloat line[MAX_SIDE];
static float amplitude[MAX_SIDE * MAX_SIDE];

static arm_cfft_instance_f32 transform;

int phase_symmetry_bytes(int side) {
    int pixels = side * side;
    return pixels * (int)((SCALES + ORIENTATIONS + 1) * sizeof(float) + 2 * sizeof(cfloat)) +
           side * (int)sizeof(cfloat);
}

void make_filters(int side) {
    const float pi = 3.14159265f;
    arm_cfft_init_f32(&transform, side);
    for (int row = 0; row < side; row++) {
        for (int column = 0; column < side; column++) {
            float fy = (float)(row < side / 2 ? row : row - side) / side;
            float fx = (float)(column < side / 2 ? column : column - side) / side;
            float radius = sqrtf(fx * fx + fy * fy);
            float theta = atan2f(-fy, fx);
            int n = row * side + column;
            for (int s = 0; s < SCALES; s++) {
                float ratio = logf(radius * (float)(8 << s)) / logf(0.15f);
                radial[s][n] = radius > 0 ? expf(-0.5f * ratio * ratio) : 0;
            }
            for (int k = 0; k < ORIENTATIONS; k++) {
                /* 0, then -pi/6 to -5 pi/6. */
                float alpha = theta + pi / 6 * k;
                if (alpha > pi)
                    alpha -= 2 * pi;
                float ratio = alpha / (pi / 6);
                angular[k][n] = expf(-0.5f * ratio * ratio);
            }
        }
    }
}

static void transform_image(const float *image, int side) {
    for (int row = 0; row < side; row++) {
        for (int column = 0; column < side; column++)
            spectrum[row * side + column] = (cfloat){image[row * side + column], 0};
        arm_cfft_f32(&transform, &spectrum[row * side].re, FORWARD, 1);
    }
    for (int column = 0; column < side; column++) {
        for (int row = 0; row < side; row++)
            line[row] = spectrum[row * side + column];
        arm_cfft_f32(&transform, &line[0].re, FORWARD, 1);
        for (int row = 0; row < side; row++)
            spectrum[row * side + column] = line[row];
    }
}

static void filter_image(const float *radial, const float *angular, int side) {
    for (int column = 0; column < side; column++) {
        for (int row = 0; row < side; row++) {
            int n = row * side + column;
            float gain = radial[n] * angular[n];
            line[row] = (cfloat){spectrum[n].re * gain, spectrum[n].im * gain};
        }
        arm_cfft_f32(&transform, &line[0].re, INVERSE, 1);
        for (int row = 0; row < side; row++)
            filtered[row * side + column] = line[row];
    }
    for (int row = 0; row < side; row++)
        arm_cfft_f32(&transform, &filtered[row * side].re, INVERSE, 1);
}

void phase_symmetry(const float *image, int side, float threshold, float *symmetry) {
    int pixels = side * side;
    for (int n = 0; n < pixels; n++)
        symmetry[n] = amplitude[n] = 0;
    transform_image(image, side);
    for (int s = 0; s < SCALES; s++) {
        for (int k = 0; k < ORIENTATIONS; k++) {
            filter_image(radial[s], angular[k], side);
            for (int n = 0; n < pixels; n++) {
                cfloat c = filtered[n];
                float excess = c.re - fabsf(c.im) - threshold;
                if (excess > 0)
                    symmetry[n] += excess;
                amplitude[n] += sqrtf(c.re * c.re + c.im * c.im);
            }
        }
    }
    for (int n = 0; n < pixels; n++)
        symmetry[n] /= amplitude[n] + 1e-10f;
}
