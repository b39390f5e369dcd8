/* RF to bone map and surface by one object: core/examples/bone_map.rs in C, with the same bits. */

#include <inttypes.h>
#include <math.h>
#include <stdalign.h>
#include <stdio.h>
#include <string.h>

#include "bonebeam.h"

enum { ELEMENTS = 16, RECORD = 384, LINES = 64, SIDE = 64 };

/* bonebeam_frame_bytes on a workstation gives this number, and on AArch64, with vectors, the other. */
#ifdef __aarch64__
static alignas(BONEBEAM_ALIGN) unsigned char memory[281664];
#else
static alignas(BONEBEAM_ALIGN) unsigned char memory[202560];
#endif
static float rf[ELEMENTS][RECORD];

static double surface(double x) { return 8e-3 + 60.0 * x * x; }

/* In place of a scanner: echoes from a bent surface near the line. */
static void echoes(double line_x) {
    memset(rf, 0, sizeof rf);
    for (int m = 0; m < ELEMENTS; m++)
        for (int k = -3; k <= 3; k++) {
            const double x = line_x + k * 0.1e-3, z = surface(x);
            const double d = (m - (ELEMENTS - 1) / 2.0) * 0.3e-3 - x;
            const double arrival = (2.0 * z + d * d / (2.0 * z)) / 1540.0 * 20e6;
            for (int sample = (int)arrival - 3; sample < (int)arrival + 5; sample++) {
                const double s = (sample - arrival) / 4.0, window = (1.0 - s * s) * (1.0 - s * s);
                rf[m][sample] += (float)(window * window * (1.0 - 11.0 * s * s));
            }
        }
}

/* In place of a watchdog, which this would reset. */
static void kick(void *steps, size_t done) { *(size_t *)steps = done; }

static void print(const char *name, const float *values, int count, const char *end) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (int i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x100000001b3);
    }
    printf("%s %08" PRIx32 "%08" PRIx32 "%s", name, (uint32_t)(hash >> 32), (uint32_t)hash, end);
}

/* A field outside its range is named, and needs no bytes. */
static int names(bonebeam_frame_parameters parameters, const char *name, double value, const char *expected) {
    bonebeam_refusal refusal;
    return bonebeam_frame_check(&parameters, &refusal) == BONEBEAM_STATUS_PARAMETER && strcmp(refusal.name, name) == 0 &&
           refusal.value == value && strcmp(refusal.expected, expected) == 0 && bonebeam_frame_bytes(&parameters) == 0;
}

static int refusals(const bonebeam_frame_parameters *parameters) {
    bonebeam_frame_parameters fewer = *parameters, gate = *parameters, image = *parameters;
    fewer.scan.aperture.min_elements = ELEMENTS + 1;
    gate.scan.gate_from = 9e-3;
    gate.scan.gate_to = 8e-3;
    image.image.rows = 100;
    bonebeam_refusal none;
    return bonebeam_frame_check(parameters, &none) == BONEBEAM_STATUS_OK && none.name[0] == 0 &&
           names(fewer, "min_elements", ELEMENTS + 1, "at most the number of elements") &&
           names(gate, "depth gate's end", 8e-3, "a depth in metres below the gate's start") &&
           names(image, "image rows", 100, "a power of two: 64, 128, 256, 512 or 1024");
}

static bonebeam_status run(void) {
    const double scales[] = {1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0};
    const bonebeam_axis lines = {-31.5 * 0.15e-3, 0.15e-3, LINES};
    const bonebeam_frame_parameters parameters = {
        .scan =
            {
                .delay =
                    {
                        .sound_speed = 1540.0,
                        .sampling_rate = 20e6,
                        .frequency = 5e6,
                        .output_rate = 20e6,
                        .output_start = 2.0 * 4e-3 / 1540.0,
                        .output_samples = 208,
                        .elements = ELEMENTS,
                        .record_samples = RECORD,
                    },
                .aperture = {.elements = ELEMENTS, .pitch = 0.3e-3, .f_number = 1.5, .min_elements = 8},
                .lines = lines,
                .block = 64,
            },
        .beamformer = {.method = "mv"},
        .image = {.rows = SIDE, .columns = SIDE, .scales = scales, .scale_count = 3, .threshold = 10.0f},
        .dynamic_range = 50.0f,
        .median = 1,
        .surface_from = 5e-3,
        .surface_to = INFINITY,
        .surface_coherence = 0.4e-3,
    };
    if (!refusals(&parameters)) return BONEBEAM_STATUS_OTHER;
    bonebeam_frame *frame;
    bonebeam_status status = bonebeam_frame_new(memory, sizeof memory, &parameters, &frame);
    for (int k = 0; k < LINES && status == BONEBEAM_STATUS_OK; k++) {
        const bonebeam_rf_wave wave = {{.law = BONEBEAM_LAW_FOCUSED}, rf[0]};
        echoes(lines.first + k * lines.step);
        status = bonebeam_frame_line(frame, k, &wave, 1, NULL);
    }
    const float *image, *map;
    size_t steps = 0;
    if (status == BONEBEAM_STATUS_OK) status = bonebeam_frame_image(frame, NULL, NULL, &image);
    if (status == BONEBEAM_STATUS_OK) status = bonebeam_frame_map(frame, kick, &steps, &map);
    bonebeam_point points[LINES];
    if (status == BONEBEAM_STATUS_OK) status = bonebeam_frame_surface(frame, points);
    if (status != BONEBEAM_STATUS_OK) return status;
    /* The surface's own mean bends at the first and last lines. */
    for (int k = 8; k < LINES - 8; k++)
        if (!points[k].found || fabs(points[k].depth - surface(lines.first + k * lines.step)) > 0.1e-3)
            return BONEBEAM_STATUS_OTHER;

    float surface[2 * LINES];
    for (int k = 0; k < LINES; k++) {
        surface[2 * k] = points[k].depth;
        surface[2 * k + 1] = points[k].confidence;
    }
    print("bone-map", map, SIDE * SIDE, " ");
    print("surface", surface, 2 * LINES, "\n");
    return steps > 0 ? status : BONEBEAM_STATUS_OTHER;
}

int main(void) {
    const bonebeam_status status = run();
    if (status != BONEBEAM_STATUS_OK) printf("%s\n", bonebeam_status_text(status));
    return status != BONEBEAM_STATUS_OK;
}
