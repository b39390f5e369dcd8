/* The golden cases in C: prints the same lines as the Rust ones, on a workstation and on a Cortex-M7.
 *
 * The numbers are tests/golden/snapshots_m32.bin, which the assembler includes. */

#include <inttypes.h>
#include <math.h>
#include <stdalign.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
enum { OUT = 64, M = 8, RECORD = LENGTH / M, SCRATCH = 1280 };
static const bonebeam_delay_parameters delay_parameters = {
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
static alignas(BONEBEAM_DELAY_ALIGN) unsigned char delay_storage[BONEBEAM_DELAY_SIZE];
static const double linear[M] = {-1.05e-3, -0.75e-3, -0.45e-3, -0.15e-3,
                                 0.15e-3,  0.45e-3,  0.75e-3,  1.05e-3};
static const bonebeam_scan_line focused = {
    .wave.law = BONEBEAM_LAW_FOCUSED,
    .wave.t0 = 0.1e-6,
    .x = 0.2e-3,
    .element_x = linear,
    .active = {1, 6},
};
static float rf[LENGTH], scratch[SCRATCH];
static bonebeam_complex out[OUT * M];

static void delay(void) {
    static const struct {
        const char *name;
        bonebeam_law law;
        double angle, x;
    } lines[] = {{"delay-focused", BONEBEAM_LAW_FOCUSED, 0.0, 0.0},
                 {"delay-focused-plane", BONEBEAM_LAW_PLANE, 0.1, 0.0},
                 {"delay-focused-plane-element", BONEBEAM_LAW_ELEMENT, 0.0, 0.45e-3}};
    for (int i = 0; i < LENGTH; i++) rf[i] = snapshots[i].re;
    bonebeam_delay *stage;
    check(bonebeam_delay_init(delay_storage, sizeof delay_storage, &delay_parameters, &stage), "delay");
    for (int i = 0; i < 3; i++) {
        const bonebeam_scan_line line = {
            .wave.law = lines[i].law,
            .wave.angle = lines[i].angle,
            .wave.x = lines[i].x,
            .wave.t0 = 0.1e-6,
            .x = 0.2e-3,
            .element_x = linear,
            .active = {1, 6},
            .add = i > 0,
        };
        if (bonebeam_delay_scratch(&delay_parameters) > SCRATCH) exit(2);
        check(bonebeam_delay_line(stage, &line, rf, scratch, SCRATCH, out), lines[i].name);
        print(lines[i].name, out, 2 * OUT * M);
    }
}

/* From 100 MHz to 20 MHz: each record is halved twice before it is read. */
static void delay_halved(void) {
    bonebeam_delay_parameters parameters = delay_parameters;
    parameters.sampling_rate = 100e6;
    if (bonebeam_delay_scratch(&parameters) > SCRATCH) exit(2);
    bonebeam_delay *stage;
    check(bonebeam_delay_init(delay_storage, sizeof delay_storage, &parameters, &stage), "delay");
    check(bonebeam_delay_line(stage, &focused, rf, scratch, SCRATCH, out), "delay-halved");
    print("delay-halved", out, 2 * OUT * M);
}

/* The focused wave through a filter in single precision; then a stage that is changed in place. */
static void delay_in_f32(void) {
    static bonebeam_complex again[OUT * M];
    bonebeam_delay *stage;
    check(bonebeam_delay_init_in_f32(delay_storage, sizeof delay_storage, &delay_parameters, &stage),
          "delay in f32");
    check(bonebeam_delay_line(stage, &focused, rf, scratch, SCRATCH, out), "delay-filter-f32");
    print("delay-filter-f32", out, 2 * OUT * M);

    /* There and back. */
    bonebeam_delay_parameters faster = delay_parameters;
    faster.sound_speed = 1600.0;
    check(bonebeam_delay_set_in_f32(stage, &faster), "delay set");
    check(bonebeam_delay_line(stage, &focused, rf, scratch, SCRATCH, again), "delay set");
    int faults = memcmp(out, again, sizeof out) == 0;
    faster.record_samples = 0;
    faults += bonebeam_delay_set(stage, &faster) != BONEBEAM_STATUS_PARAMETER;
    check(bonebeam_delay_set_in_f32(stage, &delay_parameters), "delay set");
    check(bonebeam_delay_line(stage, &focused, rf, scratch, SCRATCH, again), "delay set");
    faults += memcmp(out, again, sizeof out) != 0;
    check(bonebeam_delay_set(stage, &delay_parameters), "delay set");
    check(bonebeam_delay_line(stage, &focused, rf, scratch, SCRATCH, again), "delay set");
    faults += memcmp(out, again, sizeof out) == 0;
    if (faults) {
        printf("%d of the changed stages are not as they should be\n", faults);
        exit(1);
    }
}

/* RF along a ray of a convex array, from a wave that converges and from the first of some waves. */
static void rays(void) {
    static bonebeam_element elements[M];
    static const double delays[M] = {0.0, 0.1e-6, 0.2e-6, NAN, 0.2e-6, 0.3e-6, 0.1e-6, 0.0};
    bonebeam_delay *stage;
    check(bonebeam_delay_init(delay_storage, sizeof delay_storage, &delay_parameters, &stage), "delay");
    check(bonebeam_convex_array(0.3e-3, 20e-3, elements, M), "convex array");
    bonebeam_scan_line line = {
        .wave.law = BONEBEAM_LAW_SOURCE,
        .wave.x = 0.1e-3,
        .wave.z = 1.1e-3,
        .wave.t0 = 0.1e-6,
        .elements = elements,
        .pitch = 0.3e-3,
        .active = {1, 6},
    };
    check(bonebeam_normal(&line, M, 5.3), "normal");
    check(bonebeam_delay_line(stage, &line, rf, scratch, SCRATCH, out), "delay-ray-source");
    print("delay-ray-source", out, 2 * OUT * M);
    line.wave.law = BONEBEAM_LAW_DELAYS;
    line.wave.delays = delays;
    line.add = 1;
    check(bonebeam_delay_line(stage, &line, rf, scratch, SCRATCH, out), "delay-ray-source-delays");
    print("delay-ray-source-delays", out, 2 * OUT * M);
}

static int16_t thousandths(float x) {
    x *= 1000.0f;
    return x > 32767.0f ? 32767 : x < -32768.0f ? -32768 : (int16_t)x;
}

static int16_t counts[LENGTH][2];

/* The delay stage from I/Q: the snapshots as 32 elements of 48 samples, interleaved as they are; and the
 * same as counts of a thousandth. */
static void iq(void) {
    enum { LINE = 40, LAGS = 7 * ELEMENTS };
    static alignas(BONEBEAM_IQ_ALIGN) unsigned char storage[BONEBEAM_IQ_SIZE];
    static double element_x[ELEMENTS];
    static float lags[LAGS];
    static bonebeam_complex aligned[LINE * ELEMENTS];
    static const char *const names[] = {"iq-linear", "iq-cubic", "iq-sinc"};
    bonebeam_iq_parameters parameters = {
        .sound_speed = 1540.0,
        .sampling_rate = 10e6,
        .demodulation_frequency = 5.1e6,
        .output_rate = 12e6,
        .output_start = 0.4e-6,
        .output_samples = LINE,
        .elements = ELEMENTS,
        .record_samples = SAMPLES,
    };
    const bonebeam_scan_line line = {
        .wave.law = BONEBEAM_LAW_SOURCE,
        .wave.x = 1e-3,
        .wave.z = -4e-3,
        .wave.t0 = 0.1e-6,
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
        if (bonebeam_iq_scratch(&parameters) > LAGS) exit(2);
        check(bonebeam_iq_init(storage, sizeof storage, &parameters, &stage), "iq");
        if (i < 3) {
            check(bonebeam_iq_line(stage, &line, snapshots, BONEBEAM_LAYOUT_INTERLEAVED, lags,
                                   LAGS, aligned),
                  names[i]);
            print(names[i], aligned, 2 * LINE * ELEMENTS);
        } else {
            check(bonebeam_iq_line_counts(stage, &line, counts[0], 1e-3f,
                                          BONEBEAM_LAYOUT_INTERLEAVED, lags, LAGS, aligned),
                  "iq-counts");
            print("iq-counts", aligned, 2 * LINE * ELEMENTS);
        }
    }
    /* In fixed point: along the ray, then straight down. */
    bonebeam_scan_line down = line;
    down.wave.law = BONEBEAM_LAW_FOCUSED;
    down.x = 0.3e-3;
    down.steering = 0.0;
    parameters.reading = BONEBEAM_READING_LINEAR_FIXED;
    check(bonebeam_iq_init(storage, sizeof storage, &parameters, &stage), "iq-fixed");
    check(bonebeam_iq_line_counts(stage, &line, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED, lags,
                                  LAGS, aligned),
          "iq-fixed");
    print("iq-fixed", aligned, 2 * LINE * ELEMENTS);
    check(bonebeam_iq_line_counts(stage, &down, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED, lags,
                                  LAGS, aligned),
          "iq-fixed-down");
    print("iq-fixed-down", aligned, 2 * LINE * ELEMENTS);
}

/* Lines of I/Q in stretches shorter than the aperture's growth, each of two waves. */
static void iq_lines(void) {
    enum { OUTPUTS = 44, STRETCH = 7, HELD = STRETCH + 2, LAGS = 7 * ELEMENTS };
    static alignas(BONEBEAM_IQ_LINES_ALIGN) unsigned char storage[BONEBEAM_IQ_LINES_SIZE];
    static alignas(BONEBEAM_32_16_ALIGN) unsigned char work[BONEBEAM_32_16_SIZE];
    static float lags[LAGS];
    static bonebeam_complex aligned[HELD * ELEMENTS], z[OUTPUTS];
    bonebeam_iq_scan scan = {
        .elements = ELEMENTS,
        .pitch = 0.2e-3,
        .lines = {-1.1e-3, 1.1e-3, 3},
        .sound_speed = 1540.0,
        .centre_frequency = 5e6,
        .sampling_rate = 10e6,
        .record_samples = SAMPLES,
        .demodulation_frequency = 5.1e6,
        .reading = BONEBEAM_READING_SINC,
        .output_rate = 12e6,
        .start = 0.4e-6,
        .end = 4.0e-6,
        .f_number = 0.7,
        .min_elements = 8,
    };
    const bonebeam_beamform_parameters parameters = {
        .method = BONEBEAM_METHOD_MV,
        .temporal_half_window = 1,
        .diagonal_loading = 0.05f,
        .subaperture_ratio = 0.5,
    };
    const bonebeam_iq_wave waves[2] = {
        {{.law = BONEBEAM_LAW_PLANE, .angle = -0.1, .t0 = 0.1e-6}, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED},
        {{.law = BONEBEAM_LAW_PLANE, .angle = 0.15, .t0 = 0.1e-6}, counts[0], 1e-3f, BONEBEAM_LAYOUT_INTERLEAVED},
    };
    const bonebeam_line_memory memory = {STRETCH, lags, aligned};
    static const char *const names[] = {"pipeline-iq-left", "pipeline-iq-middle"};
    bonebeam_iq_lines *lines;
    bonebeam_32_16 *own;
    check(bonebeam_iq_lines_init(storage, sizeof storage, &scan, &parameters, &lines), "iq lines");
    check(bonebeam_32_16_init(work, sizeof work, &parameters, &own), "init");
    bonebeam_line_lengths lengths = bonebeam_iq_lines_lengths(lines, STRETCH);
    if (lengths.samples != OUTPUTS || lengths.scratch != LAGS || lengths.aligned != HELD * ELEMENTS) exit(2);
    for (int i = 0; i < 2; i++) {
        check(bonebeam_32_16_iq_line(own, lines, i, waves, 2, &memory, z), names[i]);
        print(names[i], z, 2 * OUTPUTS);
    }

    /* Within a depth gate samples are as without it. */
    static bonebeam_complex gated[OUTPUTS];
    scan.gate_from = 1e-3;
    scan.gate_to = 2e-3;
    check(bonebeam_iq_lines_init(storage, sizeof storage, &scan, &parameters, &lines), "gate");
    check(bonebeam_32_16_iq_line(own, lines, 1, waves, 2, &memory, gated), "gate");
    int faults = 0;
    for (int n = 0; n < OUTPUTS; n++) {
        double depth = 1540.0 * (scan.start + n / scan.output_rate) / 2.0;
        int inside = depth >= scan.gate_from && depth <= scan.gate_to;
        faults += (memcmp(&gated[n], &z[n], sizeof z[n]) == 0) != inside;
    }
    faults += bonebeam_32_16_iq_line(own, lines, 3, waves, 2, &memory, z) == BONEBEAM_STATUS_OK;
    faults += bonebeam_32_16_iq_line(own, lines, 0, waves, 17, &memory, z) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_32_16_iq_line(own, lines, 0, waves, 0, &memory, z) != BONEBEAM_STATUS_PARAMETER;
    if (faults) {
        printf("%d of the lines of I/Q are not as they should be\n", faults);
        exit(1);
    }
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

    /* The growing aperture, adaptive within a depth gate and DAS elsewhere. */
    bonebeam_beamform_parameters parameters = {
        .method = BONEBEAM_METHOD_MV,
        .temporal_half_window = 2,
        .diagonal_loading = 0.05f,
        .subaperture_ratio = 0.5,
    };
    const bonebeam_samples gate = {13, 38};
    bonebeam_32_16 *own;
    check(bonebeam_32_16_init(storage, sizeof storage, &parameters, &own), "init");
    check(bonebeam_32_16_line_within(own, snapshots, SAMPLES, ELEMENTS, growing, &gate, z),
          "mv-depth-gate");
    print("mv-depth-gate", z, 2 * SAMPLES);

    /* The first four elements' samples over and over again: covariances of rank 4 at most, without loading. */
    static bonebeam_complex periodic[LENGTH];
    for (int n = 0; n < LENGTH; n++) periodic[n] = snapshots[n - n % ELEMENTS + n % ELEMENTS % 4];
    parameters.diagonal_loading = 0.0f;
    check(bonebeam_32_16_init(storage, sizeof storage, &parameters, &own), "init");
    check(bonebeam_32_16_line(own, periodic, SAMPLES, ELEMENTS, all, z), "mv-singular");
    print("mv-singular", z, 2 * SAMPLES);
}

/* The snapshots as 32 beams of 48 samples. */
static void image(void) {
    static float envelopes[LENGTH], levels[LENGTH], pixels[PIXELS], smooth[PIXELS];
    const bonebeam_axis beams = {0.0, 1.0 / 31.0, ELEMENTS}, samples = {0.0, 1.0 / 47.0, SAMPLES},
                        rows = {0.0, 1.0 / 60.0, SIDE}, columns = {-0.01, 1.0 / 63.0, SIDE};
    check(bonebeam_envelope(snapshots, LENGTH, envelopes), "envelope");
    print("envelope", envelopes, LENGTH);
    float largest = bonebeam_largest(envelopes, LENGTH);
    check(bonebeam_log_compression(BONEBEAM_LOGARITHM_POLYNOMIAL, envelopes, LENGTH, largest, 50.0f,
                                   pixels),
          "log-compression-polynomial");
    check(bonebeam_log_compression(BONEBEAM_LOGARITHM_EXACT, envelopes, LENGTH, largest, 50.0f, levels),
          "log-compression");
    print("log-compression", levels, LENGTH);
    print("log-compression-polynomial", pixels, LENGTH);
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
    delay_halved();
    delay_in_f32();
    beamform();
    image();
    phase_symmetry();
    iq();
    rays();
    iq_lines();
    refusals();
    return 0;
}
