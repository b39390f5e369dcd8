/* The golden cases in C: prints the same lines as the Rust ones, on a workstation and on a Cortex-M7.
 *
 * The numbers are tests/golden/snapshots_m32.bin, which the assembler includes. */

#include <inttypes.h>
#include <stdalign.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "bonebeam.h"

enum { ELEMENTS = 32, SAMPLES = 48, LENGTH = ELEMENTS * SAMPLES, SIDE = 64, PIXELS = SIDE * SIDE };

extern const bonebeam_complex snapshots[LENGTH];
__asm__(".section .rodata\n.balign 8\n.globl snapshots\nsnapshots:\n.incbin \"snapshots_m32.bin\"\n.text\n");

/* FNV-1a over the bits of floats. */
static uint64_t hash(const void *values, size_t floats) {
    const uint8_t *byte = values;
    uint64_t sum = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < 4 * floats; i++) sum = (sum ^ byte[i]) * UINT64_C(0x100000001b3);
    return sum;
}

static void print(const char *name, const void *values, size_t floats) {
    uint64_t sum = hash(values, floats);
    printf("%s %08" PRIx32 "%08" PRIx32 "\n", name, (uint32_t)(sum >> 32), (uint32_t)sum);
}

static void check(bonebeam_status status, const char *what) {
    if (status == BONEBEAM_STATUS_OK) return;
    printf("%s: %s\n", what, bonebeam_status_text(status));
    exit(1);
}

/* The delay stage: the snapshots' real parts as 8 elements of 192 samples. */
static void delay(void) {
    enum { OUT = 64, M = 8, RECORD = LENGTH / M, SCRATCH = 1024 };
    static alignas(BONEBEAM_DELAY_ALIGN) unsigned char storage[BONEBEAM_DELAY_SIZE];
    static const double element_x[M] = {-1.05e-3, -0.75e-3, -0.45e-3, -0.15e-3,
                                        0.15e-3,  0.45e-3,  0.75e-3,  1.05e-3};
    static float rf[LENGTH], scratch[SCRATCH];
    static bonebeam_complex out[OUT * M];
    static const struct {
        const char *name;
        bonebeam_law law;
        double angle, x;
    } lines[] = {{"delay-focused", BONEBEAM_LAW_FOCUSED, 0.0, 0.0},
                 {"delay-focused-plane", BONEBEAM_LAW_PLANE, 0.1, 0.0},
                 {"delay-focused-plane-element", BONEBEAM_LAW_ELEMENT, 0.0, 0.45e-3}};
    const bonebeam_delay_parameters parameters = {
        .sound_speed = 1540.0,
        .sampling_rate = 40e6,
        .centre_frequency = 5e6,
        .output_rate = 20e6,
        .output_start = 0.5e-6,
        .output_samples = OUT,
        .elements = M,
        .record_samples = RECORD,
        .hilbert_taps = 8,
    };
    for (int i = 0; i < LENGTH; i++) rf[i] = snapshots[i].re;
    bonebeam_delay *stage;
    check(bonebeam_delay_init(storage, sizeof storage, &parameters, &stage), "delay");
    for (int i = 0; i < 3; i++) {
        const bonebeam_scan_line line = {
            .law = lines[i].law,
            .angle = lines[i].angle,
            .transmit_x = lines[i].x,
            .t0 = 0.1e-6,
            .x = 0.2e-3,
            .element_x = element_x,
            .active = {1, 6},
            .add = i > 0,
        };
        if (bonebeam_delay_scratch(&parameters) > SCRATCH) exit(2);
        check(bonebeam_delay_line(stage, &line, rf, scratch, SCRATCH, out), lines[i].name);
        print(lines[i].name, out, 2 * OUT * M);
    }
}

static int16_t thousandths(float x) {
    x *= 1000.0f;
    return x > 32767.0f ? 32767 : x < -32768.0f ? -32768 : (int16_t)x;
}

/* The delay stage from I/Q: the snapshots as 32 elements of 48 samples, interleaved as they are; and the
 * same as counts of a thousandth. */
static void iq(void) {
    enum { OUT = 40, SCRATCH = 7 * ELEMENTS };
    static alignas(BONEBEAM_IQ_ALIGN) unsigned char storage[BONEBEAM_IQ_SIZE];
    static double element_x[ELEMENTS];
    static int16_t counts[LENGTH][2];
    static float scratch[SCRATCH];
    static bonebeam_complex out[OUT * ELEMENTS];
    static const char *const names[] = {"iq-linear", "iq-cubic", "iq-sinc"};
    bonebeam_iq_parameters parameters = {
        .sound_speed = 1540.0,
        .sampling_rate = 10e6,
        .demodulation_frequency = 5.1e6,
        .output_rate = 12e6,
        .output_start = 0.4e-6,
        .output_samples = OUT,
        .elements = ELEMENTS,
        .record_samples = SAMPLES,
    };
    const bonebeam_scan_line line = {
        .law = BONEBEAM_LAW_SOURCE,
        .transmit_x = 1e-3,
        .transmit_z = -4e-3,
        .t0 = 0.1e-6,
        .x = 0.2e-3,
        .steering = 0.4,
        .element_x = element_x,
        .active = {3, 27},
    };
    for (int m = 0; m < ELEMENTS; m++) element_x[m] = (m - 15.5) * 0.2e-3;
    for (int i = 0; i < LENGTH; i++) {
        counts[i][0] = thousandths(snapshots[i].re);
        counts[i][1] = thousandths(snapshots[i].im);
    }
    bonebeam_iq *stage;
    /* Linear, which the counts are read by, comes first and last. */
    for (int i = 0; i < 4; i++) {
        parameters.reading = i % 3;
        if (bonebeam_iq_scratch(&parameters) > SCRATCH) exit(2);
        check(bonebeam_iq_init(storage, sizeof storage, &parameters, &stage), "iq");
        if (i < 3) {
            check(bonebeam_iq_line(stage, &line, snapshots, BONEBEAM_LAYOUT_INTERLEAVED, scratch,
                                   SCRATCH, out),
                  names[i]);
            print(names[i], out, 2 * OUT * ELEMENTS);
        } else {
            check(bonebeam_iq_line_counts(stage, &line, counts[0], 1e-3f,
                                          BONEBEAM_LAYOUT_INTERLEAVED, scratch, SCRATCH, out),
                  "iq-counts");
            print("iq-counts", out, 2 * OUT * ELEMENTS);
        }
    }
    /* In fixed point: along the ray, then straight down. */
    bonebeam_scan_line down = line;
    down.law = BONEBEAM_LAW_FOCUSED;
    down.x = 0.3e-3;
    down.steering = 0.0;
    parameters.reading = BONEBEAM_READING_LINEAR_FIXED;
    check(bonebeam_iq_init(storage, sizeof storage, &parameters, &stage), "iq-fixed");
    check(bonebeam_iq_line_counts(stage, &line, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED, scratch,
                                  SCRATCH, out),
          "iq-fixed");
    print("iq-fixed", out, 2 * OUT * ELEMENTS);
    check(bonebeam_iq_line_counts(stage, &down, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED, scratch,
                                  SCRATCH, out),
          "iq-fixed-down");
    print("iq-fixed-down", out, 2 * OUT * ELEMENTS);
}

/* The beamformers at 32/16 with K = 2. */
static void beamform(void) {
    static alignas(8) unsigned char storage[BONEBEAM_FORWARD_32_16_SIZE];
    static bonebeam_complex z[SAMPLES];
    static bonebeam_active all[SAMPLES], growing[SAMPLES];
    static const struct {
        const char *name;
        bonebeam_method method;
        int forward, grows;
    } cases[] = {
        {"das", BONEBEAM_METHOD_DAS, 0, 0},
        {"mv", BONEBEAM_METHOD_MV, 0, 0},
        {"esmv-rank1", BONEBEAM_METHOD_ESMV_RANK1, 0, 0},
        {"esmv-beta", BONEBEAM_METHOD_ESMV_BETA, 0, 0},
        {"esmv-rank3", BONEBEAM_METHOD_ESMV_RANK, 0, 0},
        {"esmv-exclude-first", BONEBEAM_METHOD_ESMV_EXCLUDE_FIRST, 0, 0},
        {"esmv-rank1-steps", BONEBEAM_METHOD_ESMV_RANK1_STEPS, 0, 0},
        {"mv-forward", BONEBEAM_METHOD_MV, 1, 0},
        {"esmv-rank1-forward", BONEBEAM_METHOD_ESMV_RANK1, 1, 0},
        {"esmv-beta-forward", BONEBEAM_METHOD_ESMV_BETA, 1, 0},
        {"esmv-exclude-first-forward", BONEBEAM_METHOD_ESMV_EXCLUDE_FIRST, 1, 0},
        {"esmv-rank1-steps-forward", BONEBEAM_METHOD_ESMV_RANK1_STEPS, 1, 0},
        {"mv-growing-aperture", BONEBEAM_METHOD_MV, 0, 1},
    };
    const bonebeam_aperture aperture = {
        .elements = ELEMENTS, .pitch = 0.3e-3, .f_number = 1.5, .min_elements = 8};
    double depths[SAMPLES];
    for (int n = 0; n < SAMPLES; n++) {
        depths[n] = 2e-3 + n * 0.3e-3;
        all[n] = (bonebeam_active){0, ELEMENTS};
    }
    check(bonebeam_active_elements(&aperture, 9.5, depths, SAMPLES, growing), "aperture");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const bonebeam_beamform_parameters parameters = {
            .method = cases[i].method,
            .beta = 0.1f,
            .rank = 3,
            .steps = 8,
            .temporal_half_window = 2,
            .diagonal_loading = 0.05f,
            .subaperture_ratio = 0.5,
        };
        const bonebeam_active *active = cases[i].grows ? growing : all;
        if (cases[i].forward) {
            bonebeam_forward_32_16 *own;
            check(bonebeam_forward_32_16_init(storage, sizeof storage, &parameters, &own), "init");
            check(bonebeam_forward_32_16_line(own, snapshots, SAMPLES, ELEMENTS, active, z),
                  cases[i].name);
        } else {
            bonebeam_32_16 *own;
            check(bonebeam_32_16_init(storage, sizeof storage, &parameters, &own), "init");
            check(bonebeam_32_16_line(own, snapshots, SAMPLES, ELEMENTS, active, z), cases[i].name);
        }
        print(cases[i].name, z, 2 * SAMPLES);
    }
}

/* The snapshots as 32 beams of 48 samples. */
static void image(void) {
    static float envelopes[LENGTH], levels[LENGTH], pixels[PIXELS], smooth[PIXELS];
    const bonebeam_axis beams = {0.0, 1.0 / 31.0, ELEMENTS}, samples = {0.0, 1.0 / 47.0, SAMPLES},
                        rows = {0.0, 1.0 / 60.0, SIDE}, columns = {-0.01, 1.0 / 63.0, SIDE};
    check(bonebeam_envelope(snapshots, LENGTH, envelopes), "envelope");
    print("envelope", envelopes, LENGTH);
    float largest = bonebeam_largest(envelopes, LENGTH);
    check(bonebeam_log_compression(envelopes, LENGTH, largest, 50.0f, levels), "log-compression");
    print("log-compression", levels, LENGTH);
    check(bonebeam_resample(levels, &beams, &samples, &rows, &columns, pixels), "resample");
    print("resample", pixels, PIXELS);
    check(bonebeam_median(pixels, SIDE, SIDE, smooth), "median");
    print("median", smooth, PIXELS);
}

static unsigned ridge(int at, int top) {
    switch (abs(at - top)) {
        case 0: return 90;
        case 1: return 70;
        case 2: return 25;
        default: return 0;
    }
}

/* Two bright ridges that cross, on speckle. */
static void phase_symmetry(void) {
    enum { FAST = 2 * 2 * SIDE * SIDE + 3 * SIDE, SLOW = 2 * SIDE * (SIDE / 2 + 1) + 3 * PIXELS };
    static float pixels[PIXELS], fast[FAST], slow[SLOW], map[PIXELS];
    static const double scales[] = {1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0};
    static const size_t strips[] = {1, 5, 16, SIDE};
    for (uint32_t n = 0; n < PIXELS; n++) {
        int row = n / SIDE, column = n % SIDE;
        unsigned speckle = (uint32_t)(n * UINT32_C(2654435761)) >> 26;
        pixels[n] = 10 + speckle + ridge(row, 38 + column / 5) + ridge(column, 45 - row / 2);
    }
    for (int i = 0; i < 4; i++) {
        const bonebeam_phase_symmetry_parameters parameters = {
            .rows = SIDE,
            .columns = SIDE,
            .strip = strips[i],
            .scales = scales,
            .scale_count = 3,
            .threshold = 3.0f,
        };
        bonebeam_lengths lengths = bonebeam_phase_symmetry_lengths(&parameters);
        if (lengths.fast > FAST || lengths.slow > SLOW || lengths.map > PIXELS) exit(2);
        char name[32];
        snprintf(name, sizeof name, "phase-symmetry-strip-%u", (unsigned)strips[i]);
        check(bonebeam_phase_symmetry(&parameters, pixels, fast, slow, map), name);
        print(name, map, PIXELS);
    }
}

/* What must be refused is. */
static void refusals(void) {
    static alignas(8) unsigned char storage[BONEBEAM_16_8_SIZE];
    bonebeam_16_8 *own = NULL;
    bonebeam_beamform_parameters parameters = {
        .method = BONEBEAM_METHOD_MV,
        .temporal_half_window = 2,
        .diagonal_loading = 0.05f,
        .subaperture_ratio = 0.5,
    };
    bonebeam_complex z[1] = {{7.0f, 7.0f}};
    const bonebeam_active all = {0, 16};
    int faults = 0;
    faults += bonebeam_16_8_init(NULL, sizeof storage, &parameters, &own) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_16_8_init(storage + 1, sizeof storage - 1, &parameters, &own) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_16_8_init(storage, 100, &parameters, &own) != BONEBEAM_STATUS_STORAGE;
    parameters.method = 77;
    faults += bonebeam_16_8_init(storage, sizeof storage, &parameters, &own) != BONEBEAM_STATUS_PARAMETER;
    parameters.method = BONEBEAM_METHOD_DAS;
    parameters.temporal_half_window = 0;
    faults += own != NULL;
    check(bonebeam_16_8_init(storage, sizeof storage, &parameters, &own), "init");
    faults += bonebeam_16_8_line(own, NULL, 1, 16, &all, z) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_16_8_line(own, snapshots, SIZE_MAX, 16, &all, z) != BONEBEAM_STATUS_LENGTH;
    const bonebeam_active beyond = {1, 16};
    faults += bonebeam_16_8_line(own, snapshots, 1, 16, &beyond, z) != BONEBEAM_STATUS_PARAMETER;
    faults += z[0].re != 7.0f;
    if (faults) {
        printf("%d refusals are not as they should be\n", faults);
        exit(1);
    }
}

int main(void) {
    delay();
    beamform();
    image();
    phase_symmetry();
    iq();
    refusals();
    return 0;
}
