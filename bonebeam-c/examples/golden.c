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

/* The recorded hashes: every postfilter's key is there, and no other name ends in "-factor". */
extern const char recorded[];
__asm__(".section .rodata\n.globl recorded\nrecorded:\n.incbin \"hashes.txt\"\n.byte 0\n.text\n");

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

/* The result of a call, by its name. */
static void result(bonebeam_status status, const char *name, const void *values, size_t floats) {
    check(status, name);
    print(name, values, floats);
}

static void none(int faults, const char *what) {
    if (faults == 0) return;
    printf("%d %s\n", faults, what);
    exit(1);
}

/* The memory of the object in use, to the byte: fast, and what phase symmetry has besides. */
enum { FAST = 4 * 4 * SIDE * SIDE + 4 * 1024, SLOW = 4 * (2 * SIDE * (SIDE / 2 + 1) + 3 * PIXELS) };
static alignas(BONEBEAM_ALIGN) unsigned char memory[FAST], slow[SLOW];

static size_t fits(size_t bytes, size_t limit) {
    if (bytes == 0 || bytes > limit) {
        printf("%lu bytes are needed of %lu\n", (unsigned long)bytes, (unsigned long)limit);
        exit(2);
    }
    return bytes;
}

/* The delay stage: the snapshots' real parts as 8 elements of 192 samples. */
enum { OUT = 64, M = 8, RECORD = LENGTH / M };
static const bonebeam_delay_parameters delay_parameters = {
    .sound_speed = 1540.0,
    .sampling_rate = 40e6,
    .frequency = 5e6,
    .output_rate = 20e6,
    .output_start = 0.5e-6,
    .output_samples = OUT,
    .elements = M,
    .record_samples = RECORD,
    .hilbert_taps = 8,
};
static const double linear[M] = {-1.05e-3, -0.75e-3, -0.45e-3, -0.15e-3,
                                 0.15e-3,  0.45e-3,  0.75e-3,  1.05e-3};
static const bonebeam_scan_line focused = {
    .wave.law = BONEBEAM_LAW_FOCUSED,
    .wave.t0 = 0.1e-6,
    .origin.x = 0.2e-3,
    .element_x = linear,
    .active = {1, 6},
};
static float rf[LENGTH];
static bonebeam_complex out[OUT * M];

static bonebeam_delay *delay_stage(const bonebeam_delay_parameters *parameters) {
    bonebeam_delay *stage;
    size_t bytes = fits(bonebeam_delay_bytes(parameters), FAST);
    check(bonebeam_delay_new(memory, bytes, parameters, &stage), "delay");
    return stage;
}

static const bonebeam_number half_window_1[] = {{"temporal_half_window", 1}};
static const bonebeam_number half_window_2[] = {{"temporal_half_window", 2}};

static bonebeam_beamformer *beamformer(const bonebeam_beamform_parameters *parameters, size_t elements) {
    bonebeam_beamformer *own;
    size_t bytes = fits(bonebeam_beamformer_bytes(parameters, elements), FAST);
    check(bonebeam_beamformer_new(memory, bytes, parameters, elements, &own), "beamformer");
    return own;
}

static bonebeam_iq *iq_stage(const bonebeam_delay_parameters *parameters) {
    bonebeam_iq *stage;
    size_t bytes = fits(bonebeam_iq_bytes(parameters), FAST);
    check(bonebeam_iq_new(memory, bytes, parameters, &stage), "iq");
    return stage;
}

static bonebeam_iq_lines *lines_of(const bonebeam_scan *scan, const bonebeam_beamform_parameters *parameters) {
    bonebeam_iq_lines *lines;
    size_t bytes = fits(bonebeam_iq_lines_bytes(scan, parameters), FAST);
    check(bonebeam_iq_lines_new(memory, bytes, scan, parameters, &lines), "iq lines");
    return lines;
}

static void delay(void) {
    static const struct {
        const char *name;
        bonebeam_law law;
        double angle, x;
    } lines[] = {{"delay-focused", BONEBEAM_LAW_FOCUSED, 0.0, 0.0},
                 {"delay-focused-plane", BONEBEAM_LAW_PLANE, 0.1, 0.0},
                 {"delay-focused-plane-element", BONEBEAM_LAW_ELEMENT, 0.0, 0.45e-3}};
    for (int i = 0; i < LENGTH; i++) rf[i] = snapshots[i].re;
    bonebeam_delay *stage = delay_stage(&delay_parameters);
    for (int i = 0; i < 3; i++) {
        const bonebeam_scan_line line = {
            .wave.law = lines[i].law,
            .wave.angle = lines[i].angle,
            .wave.x = lines[i].x,
            .wave.t0 = 0.1e-6,
            .origin.x = 0.2e-3,
            .element_x = linear,
            .active = {1, 6},
            .add = i > 0,
        };
        result(bonebeam_delay_line(stage, &line, rf, out), lines[i].name, out, 2 * OUT * M);
    }
}

/* From 100 MHz to 20 MHz: each record is halved twice before it is read. */
static void delay_halved(void) {
    bonebeam_delay_parameters parameters = delay_parameters;
    parameters.sampling_rate = 100e6;
    bonebeam_delay *stage = delay_stage(&parameters);
    result(bonebeam_delay_line(stage, &focused, rf, out), "delay-halved", out, 2 * OUT * M);
}

/* The focused wave through a filter in single precision; then a stage that is changed in place. */
static void delay_in_f32(void) {
    static bonebeam_complex again[OUT * M];
    bonebeam_delay_parameters single = delay_parameters;
    single.single_precision = 1;
    bonebeam_delay *stage = delay_stage(&single);
    result(bonebeam_delay_line(stage, &focused, rf, out), "delay-filter-f32", out, 2 * OUT * M);

    /* There and back. What is refused on the way changes nothing. */
    bonebeam_delay_parameters other = single;
    other.sound_speed = 1600.0;
    check(bonebeam_delay_set(stage, &other), "delay set");
    check(bonebeam_delay_line(stage, &focused, rf, again), "delay set");
    int faults = memcmp(out, again, sizeof out) == 0;
    check(bonebeam_delay_set(stage, &single), "delay set");
    other.record_samples = 0;
    faults += bonebeam_delay_set(stage, &other) != BONEBEAM_STATUS_PARAMETER;
    other.record_samples = RECORD;
    other.output_samples = 2 * OUT;
    faults += bonebeam_delay_set(stage, &other) != BONEBEAM_STATUS_STORAGE;
    check(bonebeam_delay_line(stage, &focused, rf, again), "delay set");
    faults += memcmp(out, again, sizeof out) != 0;
    check(bonebeam_delay_set(stage, &delay_parameters), "delay set");
    check(bonebeam_delay_line(stage, &focused, rf, again), "delay set");
    faults += memcmp(out, again, sizeof out) == 0;
    none(faults, "of the changed stages are not as they should be");
}

/* RF along a ray of a convex array, from a wave that converges and from the first of some waves. */
static void rays(void) {
    static bonebeam_element elements[M];
    static const double delays[M] = {0.0, 0.1e-6, 0.2e-6, NAN, 0.2e-6, 0.3e-6, 0.1e-6, 0.0};
    bonebeam_delay *stage = delay_stage(&delay_parameters);
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
    check(bonebeam_normal(elements, M, line.pitch, 5.3, &line.origin), "normal");
    result(bonebeam_delay_line(stage, &line, rf, out), "delay-ray-source", out, 2 * OUT * M);
    line.wave.law = BONEBEAM_LAW_DELAYS;
    line.wave.delays = delays;
    line.add = 1;
    result(bonebeam_delay_line(stage, &line, rf, out), "delay-ray-source-delays", out, 2 * OUT * M);
}

static int16_t thousandths(float x) {
    x *= 1000.0f;
    return x > 32767.0f ? 32767 : x < -32768.0f ? -32768 : (int16_t)x;
}

static int16_t counts[LENGTH][2];
static const bonebeam_iq_record counted = {
    .counts = counts[0], .scale = 1e-3f, .layout = BONEBEAM_LAYOUT_INTERLEAVED};

/* The delay stage from I/Q: the snapshots as 32 elements of 48 samples, interleaved as they are; and the
 * same as counts of a thousandth. */
static void iq(void) {
    enum { LINE = 40 };
    static double element_x[ELEMENTS];
    static bonebeam_complex aligned[LINE * ELEMENTS];
    static const char *const names[] = {"iq-linear", "iq-cubic", "iq-sinc", "iq-counts"};
    bonebeam_delay_parameters parameters = {
        .sound_speed = 1540.0,
        .sampling_rate = 10e6,
        .frequency = 5.1e6,
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
        .origin = {.x = 0.2e-3, .angle = 0.4},
        .element_x = element_x,
        .active = {3, 27},
    };
    for (int m = 0; m < ELEMENTS; m++) element_x[m] = (m - 15.5) * 0.2e-3;
    for (int i = 0; i < LENGTH; i++) {
        counts[i][0] = thousandths(snapshots[i].re);
        counts[i][1] = thousandths(snapshots[i].im);
    }
    const bonebeam_iq_record floats = {.samples = snapshots, .layout = BONEBEAM_LAYOUT_INTERLEAVED};
    bonebeam_iq *stage;
    /* Linear, which the counts are read by, comes first and last. */
    for (int i = 0; i < 4; i++) {
        parameters.interpolation = i % 3;
        stage = iq_stage(&parameters);
        result(bonebeam_iq_line(stage, &line, i < 3 ? &floats : &counted, aligned), names[i], aligned,
               2 * LINE * ELEMENTS);
    }
    /* In fixed point: along the ray, then straight down. */
    bonebeam_scan_line down = line;
    down.wave.law = BONEBEAM_LAW_FOCUSED;
    down.origin = (bonebeam_element){.x = 0.3e-3};
    parameters.interpolation = BONEBEAM_INTERPOLATION_LINEAR_FIXED;
    stage = iq_stage(&parameters);
    result(bonebeam_iq_line(stage, &line, &counted, aligned), "iq-fixed", aligned, 2 * LINE * ELEMENTS);
    result(bonebeam_iq_line(stage, &down, &counted, aligned), "iq-fixed-down", aligned, 2 * LINE * ELEMENTS);
}

/* A scan of I/Q in blocks shorter than the aperture's growth, each line of two waves. */
enum { OUTPUTS = 44, LINES = 3 };
static const bonebeam_scan scan_of_iq = {
    .delay =
        {
            .sound_speed = 1540.0,
            .sampling_rate = 10e6,
            .frequency = 5.1e6,
            .output_rate = 12e6,
            .output_start = 0.4e-6,
            .output_samples = OUTPUTS,
            .elements = ELEMENTS,
            .record_samples = SAMPLES,
            .interpolation = BONEBEAM_INTERPOLATION_SINC,
        },
    .aperture = {.elements = ELEMENTS, .pitch = 0.2e-3, .f_number = 0.7, .min_elements = 8},
    .lines = {-1.1e-3, 1.1e-3, LINES},
    .block = 7,
};
static const bonebeam_beamform_parameters mv_half_window_1 = {
    .method = "mv", .numbers = half_window_1, .count = 1};
static const bonebeam_iq_wave waves_of_iq[2] = {
    {{.law = BONEBEAM_LAW_PLANE, .angle = -0.1, .t0 = 0.1e-6}, counted},
    {{.law = BONEBEAM_LAW_PLANE, .angle = 0.15, .t0 = 0.1e-6}, counted},
};

static void iq_lines(void) {
    static bonebeam_complex z[OUTPUTS];
    bonebeam_scan scan = scan_of_iq;
    const bonebeam_beamform_parameters parameters = mv_half_window_1;
    const bonebeam_iq_wave *waves = waves_of_iq;
    static const char *const names[] = {"pipeline-iq-left", "pipeline-iq-middle"};
    bonebeam_iq_lines *lines = lines_of(&scan, &parameters);
    for (int i = 0; i < 2; i++) {
        result(bonebeam_iq_lines_line(lines, i, waves, 2, z), names[i], z, 2 * OUTPUTS);
    }

    /* Sub-lines of lines and of a frame, if the library has them. */
    enum { SUB_LINES = 4 };
    bonebeam_beamform_parameters several = mv_half_window_1;
    several.sub_lines = SUB_LINES;
    int faults = 0;
    if (bonebeam_iq_lines_bytes(&scan, &several) > 0) {
        static alignas(BONEBEAM_ALIGN) unsigned char place[4 * FAST];
        static bonebeam_complex all[OUTPUTS * SUB_LINES], of_frame[OUTPUTS * SUB_LINES];
        lines = lines_of(&scan, &several);
        check(bonebeam_iq_lines_line(lines, 1, waves, 2, all), "sub-lines");
        print("sub-lines-pipeline-iq", all, 2 * OUTPUTS * SUB_LINES);
        const double scale = 0.125;
        bonebeam_frame_parameters of = {
            .scan = scan,
            .beamformer = several,
            .image = {.rows = SIDE, .columns = SIDE, .scales = &scale, .scale_count = 1, .threshold = 3.0f},
            .dynamic_range = 50.0f,
        };
        static float by_largest[PIXELS];
        for (of.pool_by_rms = 0; of.pool_by_rms < 2; of.pool_by_rms++) {
            bonebeam_frame *frame;
            const float *image;
            check(bonebeam_frame_iq_new(place, fits(bonebeam_frame_iq_bytes(&of), sizeof place), &of, &frame),
                  "frame of sub-lines");
            for (int k = 0; k < LINES; k++)
                check(bonebeam_frame_iq_line(frame, k, waves, 2, k == 1 ? of_frame : NULL), "line of sub-lines");
            faults += memcmp(of_frame, all, sizeof all) != 0;
            check(bonebeam_frame_image(frame, NULL, NULL, &image), "image of sub-lines");
            if (of.pool_by_rms) faults += memcmp(image, by_largest, sizeof by_largest) == 0;
            memcpy(by_largest, image, sizeof by_largest);
        }
        several.sub_lines = 3;
        faults += bonebeam_iq_lines_bytes(&scan, &several) != 0;
    }
    faults += bonebeam_beamformer_bytes(&several, ELEMENTS) != 0;

    /* Within a depth gate samples are as without it. */
    static bonebeam_complex gated[OUTPUTS];
    scan.gate_from = 1e-3;
    scan.gate_to = 2e-3;
    lines = lines_of(&scan, &parameters);
    check(bonebeam_iq_lines_line(lines, 1, waves, 2, gated), "gate");
    for (int n = 0; n < OUTPUTS; n++) {
        double depth = 1540.0 * (scan.delay.output_start + n / scan.delay.output_rate) / 2.0;
        int inside = depth >= scan.gate_from && depth <= scan.gate_to;
        faults += (memcmp(&gated[n], &z[n], sizeof z[n]) == 0) != inside;
    }
    faults += bonebeam_iq_lines_line(lines, 3, waves, 2, z) == BONEBEAM_STATUS_OK;
    faults += bonebeam_iq_lines_line(lines, 0, waves, 17, z) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_iq_lines_line(lines, 0, waves, 0, z) != BONEBEAM_STATUS_PARAMETER;
    /* Of another number of elements, and so late that doubles do not tell samples apart. */
    scan.aperture.elements = ELEMENTS - 1;
    faults += bonebeam_iq_lines_bytes(&scan, &parameters) != 0;
    scan.aperture.elements = ELEMENTS;
    scan.gate_from = scan.gate_to = 0.0;
    scan.delay.output_start = 4e9;
    faults += bonebeam_iq_lines_new(memory, FAST, &scan, &parameters, &lines) != BONEBEAM_STATUS_PARAMETER;
    none(faults, "of the lines of I/Q are not as they should be");
}

/* Lines at every s-th sample have that many numbers less. */
typedef struct {
    const char *name, *method;
    double argument, half_window, step;
    int options;
    const char *apodization;
} beamform_case;

/* An aperture that grows; adaptive within a depth gate and DAS elsewhere; the first four elements' samples over and
 * over again, covariances of rank 4 at most, without loading. */
enum { FORWARD = 1, GROWS = 2, GATED = 4, SINGULAR = 8 };

static void beamform_by(const beamform_case *own, const char *name, const char *postfilter) {
    static bonebeam_complex z[SAMPLES], x[LENGTH];
    static bonebeam_range active[SAMPLES];
    static double depths[SAMPLES];
    const bonebeam_aperture aperture = {
        .elements = ELEMENTS, .pitch = 0.3e-3, .f_number = 1.5, .min_elements = 8};
    const bonebeam_range gate = {13, 25};
    const bonebeam_number numbers[] = {
        {"temporal_half_window", own->half_window}, {"depth_step", own->step}, {"diagonal_loading", 0}};
    const bonebeam_beamform_parameters parameters = {
        .method = own->method,
        .covariance = own->options & FORWARD ? BONEBEAM_COVARIANCE_FORWARD : BONEBEAM_COVARIANCE_FORWARD_BACKWARD,
        .argument = own->argument,
        .postfilter = postfilter,
        .apodization = own->apodization,
        .numbers = numbers,
        .count = own->options & SINGULAR ? 3 : 2,
    };
    for (int n = 0; n < SAMPLES; n++) {
        depths[n] = 2e-3 + n * 0.3e-3;
        active[n] = (bonebeam_range){0, ELEMENTS};
    }
    if (own->options & GROWS) check(bonebeam_active_elements(&aperture, 9.5, depths, SAMPLES, active), "aperture");
    for (int n = 0; n < LENGTH; n++)
        x[n] = snapshots[own->options & SINGULAR ? n - n % ELEMENTS + n % ELEMENTS % 4 : n];
    result(bonebeam_beamformer_line(beamformer(&parameters, ELEMENTS), x, SAMPLES, ELEMENTS, active,
                                    own->options & GATED ? &gate : NULL, z),
           name, z, 2 * SAMPLES / (size_t)own->step);
}

/* The beamformers at 32/16 with K = 2. */
static void beamform(void) {
    static const beamform_case cases[] = {
        {"das", "das", 0, 2, 1, 0, NULL},
        {"mv", "mv", 0, 2, 1, 0, NULL},
        {"esmv-rank1", "esmv-rank1", 0, 2, 1, 0, NULL},
        {"esmv-beta", "esmv-beta", 0.1, 2, 1, 0, NULL},
        {"esmv-rank3", "esmv-rank", 3, 2, 1, 0, NULL},
        {"esmv-exclude-first", "esmv-exclude-first", 0, 2, 1, 0, NULL},
        {"esmv-rank1-steps", "esmv-rank1-steps", 8, 2, 1, 0, NULL},
        {"mv-forward", "mv", 0, 2, 1, FORWARD, NULL},
        {"esmv-rank1-forward", "esmv-rank1", 0, 2, 1, FORWARD, NULL},
        {"esmv-beta-forward", "esmv-beta", 0.1, 2, 1, FORWARD, NULL},
        {"esmv-exclude-first-forward", "esmv-exclude-first", 0, 2, 1, FORWARD, NULL},
        {"esmv-rank1-steps-forward", "esmv-rank1-steps", 8, 2, 1, FORWARD, NULL},
        {"mv-growing-aperture", "mv", 0, 2, 1, GROWS, NULL},
        {"mv-growing-aperture-depth-step-3", "mv", 0, 2, 3, GROWS, NULL},
        {"mv-depth-gate", "mv", 0, 2, 1, GROWS | GATED, NULL},
        {"mv-singular", "mv", 0, 2, 1, SINGULAR, NULL},
        {NULL, "mv", 0, 2, 1, 0, NULL}, /* by every postfilter */
        {"das-hann", "das", 0, 2, 1, 0, "hann"},
        {"mv-hamming", "mv", 0, 2, 1, 0, "hamming"},
        {"esmv-rank1-tukey", "esmv-rank1", 0, 2, 1, 0, "tukey"},
        {"das-depth-step-2", "das", 0, 0, 2, 0, NULL},
        {"esmv-rank1-depth-step-4", "esmv-rank1", 0, 0, 4, 0, NULL},
        {"mv-depth-step-3", "mv", 0, 2, 3, 0, NULL},
    };
    static const char end[] = "-factor";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (cases[i].name) {
            beamform_by(cases + i, cases[i].name, NULL);
            continue;
        }
        for (const char *line = recorded; *line != 0; line += strcspn(line, "\n") + 1) {
            static char key[64];
            size_t length = strcspn(line, " "), last = sizeof end - 1;
            if (length < last || length >= sizeof key || memcmp(line + length - last, end, last) != 0) continue;
            memcpy(key, line, length);
            key[length] = 0;
            beamform_by(cases + i, key, key);
        }
    }
}

/* The snapshots as 32 beams of 48 samples. */
static void image(void) {
    static float envelopes[LENGTH], levels[LENGTH], pixels[PIXELS], smooth[PIXELS];
    const bonebeam_axis beams = {0.0, 1.0 / 31.0, ELEMENTS}, samples = {0.0, 1.0 / 47.0, SAMPLES},
                        rows = {0.0, 1.0 / 60.0, SIDE}, columns = {-0.01, 1.0 / 63.0, SIDE};
    result(bonebeam_envelope(snapshots, LENGTH, envelopes), "envelope", envelopes, LENGTH);
    float largest = bonebeam_largest(envelopes, LENGTH);
    check(bonebeam_log_compression(BONEBEAM_LOGARITHM_POLYNOMIAL, envelopes, LENGTH, largest, 50.0f,
                                   pixels),
          "log-compression-polynomial");
    check(bonebeam_log_compression(BONEBEAM_LOGARITHM_EXACT, envelopes, LENGTH, largest, 50.0f, levels),
          "log-compression");
    print("log-compression", levels, LENGTH);
    print("log-compression-polynomial", pixels, LENGTH);
    result(bonebeam_resample(levels, &beams, &samples, &rows, &columns, pixels), "resample", pixels, PIXELS);
    result(bonebeam_median(pixels, SIDE, SIDE, smooth), "median", smooth, PIXELS);
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
    static float pixels[PIXELS], map[PIXELS];
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
        size_t bytes = fits(bonebeam_phase_symmetry_bytes(&parameters), FAST);
        size_t slow_bytes = fits(bonebeam_phase_symmetry_slow_bytes(&parameters), SLOW);
        bonebeam_phase_symmetry *own;
        char name[32];
        snprintf(name, sizeof name, "phase-symmetry-strip-%u", (unsigned)strips[i]);
        check(bonebeam_phase_symmetry_new(memory, bytes, slow, slow_bytes, &parameters, &own), name);
        result(bonebeam_phase_symmetry_map(own, pixels, map), name, map, PIXELS);
    }
}

/* An output that shares a byte with an input is refused, and nothing is written; one that only touches it is not. */
static void overlaps(void) {
    enum { OUTS = 2 * M * OUT };
    static float rf[LENGTH + OUTS];
    static bonebeam_complex x[LENGTH];
    const bonebeam_status pointer = BONEBEAM_STATUS_POINTER;
    int faults = 0;
    for (int i = 0; i < LENGTH; i++) rf[i] = 1.0f;

    bonebeam_delay *delay = delay_stage(&delay_parameters);
    const bonebeam_scan_line line = {
        .wave = {.law = BONEBEAM_LAW_PLANE}, .element_x = linear, .active = {0, M}};
    faults += bonebeam_delay_line(delay, &line, rf, (bonebeam_complex *)rf) != pointer;
    faults += bonebeam_delay_line(delay, &line, rf, (bonebeam_complex *)(rf + LENGTH - 2)) != pointer;
    faults += bonebeam_delay_line(delay, &line, rf + OUTS - 2, (bonebeam_complex *)rf) != pointer;
    faults += rf[0] != 1.0f || rf[LENGTH - 1] != 1.0f || rf[LENGTH] != 0.0f;
    faults += bonebeam_delay_line(delay, &line, rf, (bonebeam_complex *)(rf + LENGTH)) != BONEBEAM_STATUS_OK;
    faults += bonebeam_delay_line(delay, &line, rf + OUTS, (bonebeam_complex *)rf) != BONEBEAM_STATUS_OK;

    memcpy(x, snapshots, sizeof x);
    const bonebeam_beamform_parameters das = {.method = "das"};
    bonebeam_beamformer *own = beamformer(&das, ELEMENTS);
    const bonebeam_range all = {0, ELEMENTS};
    faults += bonebeam_beamformer_line(own, x, 1, ELEMENTS, &all, NULL, x) != pointer;
    faults += bonebeam_beamformer_line(own, x, 1, ELEMENTS, &all, NULL, x + ELEMENTS) != BONEBEAM_STATUS_OK;
    faults += bonebeam_envelope(x, 8, &x[7].im) != pointer;
    faults += bonebeam_log_compression(BONEBEAM_LOGARITHM_EXACT, rf, 8, 1.0f, 60.0f, rf) != pointer;
    faults += bonebeam_median(rf, 4, 4, rf) != pointer;
    const bonebeam_axis axis = {0.0, 1.0, 4};
    faults += bonebeam_resample(rf, &axis, &axis, &axis, &axis, rf + 15) != pointer;
    none(faults, "overlaps are not as they should be");
}

static int same(const void *a, const void *b, size_t floats) { return memcmp(a, b, 4 * floats) == 0; }

static void count_steps(void *steps, size_t done) {
    size_t *count = steps;
    if (done == *count + 1) *count = done;
}

/* Frames: the lines, image and map of the separate stages, which have the golden bits. Lines of I/Q, and of RF the
 * delay stage's line through a beamformer. */
static void frames(void) {
    static alignas(BONEBEAM_ALIGN) unsigned char place[4 * FAST];
    static bonebeam_complex z[LINES][OUTPUTS], line[OUTPUTS];
    static float envelopes[LINES * OUTPUTS], levels[LINES * OUTPUTS], pixels[PIXELS], smooth[PIXELS];
    const bonebeam_status pointer = BONEBEAM_STATUS_POINTER, parameter = BONEBEAM_STATUS_PARAMETER;
    const double scales[] = {0.125, 0.0625};
    bonebeam_frame_parameters parameters = {
        .scan = scan_of_iq,
        .beamformer = mv_half_window_1,
        .image = {.rows = SIDE, .columns = SIDE, .scales = scales, .scale_count = 2, .threshold = 3.0f},
        .dynamic_range = 50.0f,
        .median = 1,
    };
    bonebeam_frame *frame = NULL;
    int faults = 0;
    size_t bytes = fits(bonebeam_frame_iq_bytes(&parameters), sizeof place);
    faults += bonebeam_frame_iq_new(place, bytes - 1, &parameters, &frame) != BONEBEAM_STATUS_STORAGE;
    faults += bonebeam_frame_iq_new(place + 4, bytes, &parameters, &frame) != pointer;
    faults += bonebeam_frame_iq_new(NULL, bytes, &parameters, &frame) != pointer;
    faults += bonebeam_frame_iq_new(place, bytes, NULL, &frame) != pointer;
    faults += bonebeam_frame_iq_new(place, bytes, &parameters, NULL) != pointer;
    faults += frame != NULL;
    check(bonebeam_frame_iq_new(place, bytes, &parameters, &frame), "frame of I/Q");

    const bonebeam_beamform_parameters mv = mv_half_window_1;
    bonebeam_iq_lines *lines = lines_of(&parameters.scan, &mv);
    for (int k = LINES - 1; k >= 0; k--) {
        check(bonebeam_iq_lines_line(lines, k, waves_of_iq, 2, z[k]), "line");
        check(bonebeam_frame_iq_line(frame, k, waves_of_iq, 2, k == 1 ? NULL : line), "line of a frame");
        faults += k != 1 && !same(line, z[k], 2 * OUTPUTS);
    }
    faults += bonebeam_frame_iq_line(frame, LINES, waves_of_iq, 2, line) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_frame_iq_line(frame, 0, waves_of_iq, BONEBEAM_WAVES + 1, line) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_frame_iq_line(frame, 0, waves_of_iq, 0, line) != parameter;
    faults += bonebeam_frame_iq_line(frame, 0, NULL, 2, line) != pointer;
    faults += bonebeam_frame_iq_line(frame, 0, waves_of_iq, 2, (bonebeam_complex *)counts) != pointer;
    const bonebeam_rf_wave rf_wave = {.rf = rf};
    faults += bonebeam_frame_line(frame, 0, &rf_wave, 1, line) != parameter;
    faults += bonebeam_frame_surface(frame, NULL) != parameter;

    /* By the separate stages. */
    bonebeam_axis rows, columns;
    const double first = 1540.0 * 0.4e-6 / 2.0, step = 1540.0 / 12e6 / 2.0;
    const bonebeam_axis samples = {first, step, OUTPUTS};
    check(bonebeam_frame_axes(frame, &rows, &columns), "axes");
    check(bonebeam_envelope(z[0], LINES * OUTPUTS, envelopes), "envelope");
    check(bonebeam_log_compression(BONEBEAM_LOGARITHM_EXACT, envelopes, LINES * OUTPUTS,
                                   bonebeam_largest(envelopes, LINES * OUTPUTS), 50.0f, levels),
          "log compression");
    check(bonebeam_resample(levels, &scan_of_iq.lines, &samples, &rows, &columns, pixels), "resample");
    check(bonebeam_median(pixels, SIDE, SIDE, smooth), "median");
    const bonebeam_phase_symmetry_parameters filters = {
        .rows = SIDE, .columns = SIDE, .strip = 8, .scales = scales, .scale_count = 2, .threshold = 3.0f};
    bonebeam_phase_symmetry *bank;
    check(bonebeam_phase_symmetry_new(memory, FAST, slow, SLOW, &filters, &bank), "phase symmetry");
    check(bonebeam_phase_symmetry_map(bank, smooth, pixels), "map");

    const float *image, *map;
    size_t steps = 0;
    check(bonebeam_frame_image(frame, NULL, NULL, &image), "image of a frame");
    faults += !same(image, smooth, PIXELS) || bonebeam_largest(image, PIXELS) < 200.0f;
    check(bonebeam_frame_map(frame, count_steps, &steps, &map), "map of a frame");
    faults += !same(map, pixels, PIXELS) || steps < 10 || bonebeam_largest(map, PIXELS) < 0.1f;
    faults += bonebeam_frame_image(frame, NULL, NULL, NULL) != pointer;
    faults += bonebeam_frame_map(NULL, NULL, NULL, &map) != pointer;

    /* RF, with gains in tables: the delay stage and a beamformer with all elements. */
    parameters.scan.delay = delay_parameters;
    parameters.scan.aperture = (bonebeam_aperture){.elements = M, .pitch = 0.3e-3, .f_number = 1.5, .min_elements = M};
    parameters.scan.lines = (bonebeam_axis){-0.2e-3, 0.4e-3, 2};
    parameters.gain_tables = 1;
    bytes = fits(bonebeam_frame_bytes(&parameters), sizeof place);
    faults += bonebeam_frame_new(place, bytes - 1, &parameters, &frame) != BONEBEAM_STATUS_STORAGE;
    check(bonebeam_frame_new(place, bytes, &parameters, &frame), "frame of RF");
    static bonebeam_range active[OUT];
    static bonebeam_complex of_stages[OUT], of_frame[OUT];
    double depths[OUT];
    const bonebeam_rf_wave wave = {{.law = BONEBEAM_LAW_FOCUSED, .t0 = 0.1e-6}, rf};
    bonebeam_scan_line ray = {.wave = wave.wave, .element_x = linear, .active = {0, M}};
    for (int k = 0; k < 2; k++) {
        ray.origin.x = parameters.scan.lines.first + k * parameters.scan.lines.step;
        for (int n = 0; n < OUT; n++) depths[n] = 1540.0 * (0.5e-6 + n / 20e6) / 2.0;
        check(bonebeam_active_elements(&parameters.scan.aperture, ray.origin.x / 0.3e-3 + 3.5, depths, OUT, active),
              "aperture");
        check(bonebeam_delay_line(delay_stage(&delay_parameters), &ray, rf, out), "delay");
        check(bonebeam_beamformer_line(beamformer(&mv, M), out, OUT, M, active, NULL, of_stages), "beamformer");
        check(bonebeam_frame_line(frame, k, &wave, 1, of_frame), "line of a frame");
        faults += !same(of_frame, of_stages, 2 * OUT);
    }
    faults += bonebeam_frame_line(frame, 0, &wave, 1, (bonebeam_complex *)rf) != pointer;
    faults += bonebeam_frame_iq_line(frame, 0, waves_of_iq, 2, NULL) != parameter;
    check(bonebeam_frame_image(frame, NULL, NULL, &image), "image of a frame");
    memcpy(smooth, image, sizeof smooth);
    check(bonebeam_phase_symmetry_new(memory, FAST, slow, SLOW, &filters, &bank), "phase symmetry");
    check(bonebeam_phase_symmetry_map(bank, smooth, pixels), "map");
    check(bonebeam_frame_map(frame, NULL, NULL, &map), "map of a frame");
    faults += !same(map, pixels, PIXELS);

    /* Other Hilbert taps than the rates', other sizes than phase symmetry's, and an aperture of another array. */
    parameters.scan.delay.hilbert_taps = 9;
    faults += bonebeam_frame_new(place, sizeof place, &parameters, &frame) != parameter;
    parameters.scan.delay.hilbert_taps = 0;
    faults += bonebeam_frame_bytes(&parameters) != bytes;
    parameters.image.rows = SIDE - 1;
    faults += bonebeam_frame_bytes(&parameters) != 0;
    parameters.image.rows = SIDE;
    /* Coherence has memory where there is a surface, over a window that is a length. */
    parameters.surface_coherence = 0.4e-3;
    faults += bonebeam_frame_bytes(&parameters) != bytes;
    parameters.surface_from = 0.4e-3;
    parameters.surface_to = INFINITY;
    const size_t with_coherence = bonebeam_frame_bytes(&parameters);
    parameters.surface_coherence = 0.0;
    const size_t without = bonebeam_frame_bytes(&parameters);
    faults += without <= bytes || with_coherence <= without;
    parameters.surface_coherence = -0.4e-3;
    faults += bonebeam_frame_bytes(&parameters) != 0;
    parameters.surface_coherence = NAN;
    faults += bonebeam_frame_bytes(&parameters) != 0;
    parameters.surface_from = parameters.surface_to = 0.0;
    parameters.scan.aperture.elements = M - 1;
    faults += bonebeam_frame_bytes(&parameters) != 0;
    none(faults, "checks of frames failed");
}

/* RF in stretches of depth: blocks that are aligned and beamformed before the record's end have the whole line's
 * bits, also with a time window. What is not recorded yet is garbage. */
static void stretches(void) {
    enum { STRETCH = 50, BLOCK = 10 };
    static int16_t planar[LENGTH], stretch[M * STRETCH];
    static float record[LENGTH];
    static bonebeam_complex aligned[OUT * M], z[OUT], of_line[OUT], z_windows[OUT], of_windows[OUT];
    static bonebeam_range active[OUT];
    static alignas(BONEBEAM_ALIGN) unsigned char place[16384], other_place[16384];
    const bonebeam_beamform_parameters mv = {.method = "mv"};
    const bonebeam_beamform_parameters mv_windows = {.method = "mv", .numbers = half_window_2, .count = 1};
    const bonebeam_range all = {0, RECORD};
    int faults = 0;
    for (int i = 0; i < LENGTH; i++) planar[i] = thousandths(rf[i]);
    for (int n = 0; n < OUT; n++) {
        active[n] = focused.active;
        if (n < 23) active[n].count--;
    }
    bonebeam_delay *delay = delay_stage(&delay_parameters);
    bonebeam_beamformer *own, *windows;
    check(bonebeam_beamformer_new(place, sizeof place, &mv, M, &own), "beamformer");
    check(bonebeam_beamformer_new(other_place, sizeof other_place, &mv_windows, M, &windows), "beamformer");
    check(bonebeam_rf_counts(planar, BONEBEAM_LAYOUT_PLANAR, 1e-3f, all, M, RECORD, record), "counts");
    for (int i = 0; i < LENGTH; i++) faults += record[i] != 1e-3f * planar[i];
    check(bonebeam_delay_line(delay, &focused, record, out), "delay");
    check(bonebeam_beamformer_line(own, out, OUT, M, active, NULL, of_line), "beamformer");
    check(bonebeam_beamformer_line(windows, out, OUT, M, active, NULL, of_windows), "beamformer");

    size_t done = 0;
    for (int i = 0; i < LENGTH; i++) record[i] = 1e6f;
    bonebeam_range block = {0, BLOCK};
    int before_the_end = 0;
    for (int first = 0; first < RECORD; first += STRETCH) {
        const int count = RECORD - first < STRETCH ? RECORD - first : STRETCH;
        for (int n = 0; n < count; n++)
            for (int m = 0; m < M; m++) stretch[n * M + m] = planar[m * RECORD + first + n];
        const bonebeam_range own_samples = {first, count};
        check(bonebeam_rf_counts(stretch, BONEBEAM_LAYOUT_INTERLEAVED, 1e-3f, own_samples, M, RECORD, record), "counts");
        while (block.count > 0) {
            size_t end;
            check(bonebeam_delay_record_end(delay, &focused, block, &end), "record end");
            if (end > (size_t)(first + count)) break;
            bonebeam_complex *x = aligned + block.first * M;
            check(bonebeam_delay_block(delay, &focused, record, block, x), "block");
            check(bonebeam_beamformer_line(own, x, block.count, M, active + block.first, NULL, z + block.first), "beamformer");
            before_the_end += first + count < RECORD;
            block.first += block.count;
            /* Aligned samples above the time window of `done` are not read again. */
            const size_t kept = done < 2 ? 0 : done - 2;
            const bonebeam_range so_far = {kept, block.first - kept};
            check(bonebeam_beamformer_partial_line(windows, aligned + kept * M, so_far, OUT, M, 0.0f, active, NULL, &done, z_windows),
                  "partial line");
            faults += done > block.first || done + 3 * 2 < block.first;
            if (block.first + BLOCK > OUT) block.count = OUT - block.first;
        }
    }
    faults += block.first != OUT || before_the_end < 3;
    faults += !same(aligned, out, 2 * OUT * M) || !same(z, of_line, 2 * OUT);
    faults += done != OUT || !same(z_windows, of_windows, 2 * OUT);

    const bonebeam_range beyond = {1, OUT}, outside = {1, RECORD}, one = {0, 1};
    size_t end = 40;
    const bonebeam_range late = {40, 10};
    faults += bonebeam_beamformer_partial_line(windows, aligned, late, OUT, M, 0.0f, active, NULL, &end, z) != BONEBEAM_STATUS_PARAMETER;
    faults += bonebeam_beamformer_partial_line(windows, aligned, beyond, OUT, M, 0.0f, active, NULL, &end, z) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_beamformer_partial_line(windows, aligned, late, OUT, M, 0.0f, active, NULL, NULL, z) != BONEBEAM_STATUS_POINTER;
    faults += end != 40;
    faults += bonebeam_delay_block(delay, &focused, record, beyond, aligned) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_delay_block(delay, &focused, rf, one, (bonebeam_complex *)rf) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_delay_record_end(delay, &focused, beyond, &end) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_delay_record_end(delay, &focused, all, NULL) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_rf_counts(planar, 0, 1.0f, outside, M, RECORD, record) != BONEBEAM_STATUS_CAPACITY;
    faults += bonebeam_rf_counts(planar, 2, 1.0f, all, M, RECORD, record) != BONEBEAM_STATUS_PARAMETER;
    faults += bonebeam_rf_counts(planar, 0, 1.0f, all, M, RECORD, (float *)planar) != BONEBEAM_STATUS_POINTER;
    faults += bonebeam_rf_counts(planar, 0, 1.0f, all, SIZE_MAX, RECORD, record) != BONEBEAM_STATUS_LENGTH;
    none(faults, "checks of stretches failed");
}

/* What must be refused is. Each kind of object has its memory to the byte. */
static void refusals(void) {
    const size_t align = BONEBEAM_ALIGN;
    const bonebeam_status pointer = BONEBEAM_STATUS_POINTER, storage = BONEBEAM_STATUS_STORAGE;
    int faults = 0;
    bonebeam_beamformer *own = NULL;
    bonebeam_beamform_parameters parameters = {
        .method = "mv",
        .numbers = half_window_2,
        .count = 1,
    };
    size_t bytes = bonebeam_beamformer_bytes(&parameters, 16);
    /* The bounds of docs/c.md. */
#ifdef __aarch64__
    faults += bytes > 4 * 2880;
#else
    faults += bytes > 2880;
#endif
    faults += bonebeam_beamformer_new(NULL, bytes, &parameters, 16, &own) != pointer;
    faults += bonebeam_beamformer_new(memory + align / 2, bytes, &parameters, 16, &own) != pointer;
    faults += bonebeam_beamformer_new(memory, bytes - 1, &parameters, 16, &own) != storage;
    faults += bonebeam_beamformer_new(memory, 0, &parameters, 16, &own) != storage;
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, SIZE_MAX, &own) != storage;
    faults += bonebeam_beamformer_new(memory, bytes, NULL, 16, &own) != pointer;
    faults += bonebeam_beamformer_new(memory, bytes, &parameters, 16, NULL) != pointer;
    faults += bonebeam_beamformer_bytes(NULL, 16) != 0;
    faults += bonebeam_beamformer_bytes(&parameters, SIZE_MAX) != 0;
    parameters.covariance = 2;
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != BONEBEAM_STATUS_PARAMETER;
    parameters.covariance = BONEBEAM_COVARIANCE_FORWARD_BACKWARD;
    parameters.method = "esmv";
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != BONEBEAM_STATUS_PARAMETER;
    faults += bonebeam_beamformer_bytes(&parameters, 16) != 0;
    parameters.method = NULL;
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != pointer;
    parameters.method = "esmv-rank";
    parameters.argument = 2.5;
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != BONEBEAM_STATUS_PARAMETER;
    parameters.argument = 2.0;
    parameters.postfilter = "coherence";
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != BONEBEAM_STATUS_PARAMETER;
    parameters.postfilter = NULL;
    static const bonebeam_number wrong[] = {{"half_window", 1}, {"subaperture_ratio", 1.5}, {"temporal_half_window", 0.5}, {NULL, 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        parameters.numbers = wrong + i;
        const bonebeam_status expected = wrong[i].name ? BONEBEAM_STATUS_PARAMETER : pointer;
        faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != expected;
    }
    parameters.numbers = NULL;
    faults += bonebeam_beamformer_new(memory, FAST, &parameters, 16, &own) != pointer;
    faults += own != NULL;

    bonebeam_complex z[1] = {{7.0f, 7.0f}};
    const bonebeam_range all = {0, 16}, beyond = {1, 16};
    parameters.method = "mv";
    parameters.count = 0;
    own = beamformer(&parameters, 15);
    faults += bonebeam_beamformer_line(own, snapshots, 1, 16, &all, NULL, z) != BONEBEAM_STATUS_CAPACITY;
    parameters.method = "das";
    own = beamformer(&parameters, 16);
    faults += bonebeam_beamformer_line(own, NULL, 1, 16, &all, NULL, z) != pointer;
    faults += bonebeam_beamformer_line(own, snapshots, SIZE_MAX, 16, &all, NULL, z) != BONEBEAM_STATUS_LENGTH;
    faults += bonebeam_beamformer_line(own, snapshots, 1, 16, &beyond, NULL, z) != BONEBEAM_STATUS_PARAMETER;
    faults += z[0].re != 7.0f;

    bonebeam_delay *delay = NULL;
    bytes = bonebeam_delay_bytes(&delay_parameters);
    faults += bonebeam_delay_new(memory + align / 2, bytes, &delay_parameters, &delay) != pointer;
    faults += bonebeam_delay_new(memory, bytes - 1, &delay_parameters, &delay) != storage;
    faults += bonebeam_delay_new(memory, 0, &delay_parameters, &delay) != storage;
    faults += delay != NULL;
    bonebeam_iq *iq = NULL;
    bytes = bonebeam_iq_bytes(&delay_parameters);
    faults += bonebeam_iq_new(memory + align / 2, bytes, &delay_parameters, &iq) != pointer;
    faults += bonebeam_iq_new(memory, bytes - 1, &delay_parameters, &iq) != storage;
    faults += iq != NULL;
    const bonebeam_scan scan = {
        .delay = delay_parameters,
        .aperture = {.elements = M, .pitch = 0.3e-3, .f_number = 1.0, .min_elements = 2},
        .lines = {0.0, 1e-3, 1},
        .block = 1,
    };
    bonebeam_iq_lines *lines = NULL;
    bytes = bonebeam_iq_lines_bytes(&scan, &parameters);
    faults += bonebeam_iq_lines_new(memory + align / 2, bytes, &scan, &parameters, &lines) != pointer;
    faults += bonebeam_iq_lines_new(memory, bytes - 1, &scan, &parameters, &lines) != storage;
    faults += lines != NULL;
    const double scale = 0.125;
    const bonebeam_phase_symmetry_parameters filters = {
        .rows = SIDE, .columns = SIDE, .strip = 1, .scales = &scale, .scale_count = 1};
    bonebeam_phase_symmetry *bank = NULL;
    bytes = bonebeam_phase_symmetry_bytes(&filters);
    faults += bonebeam_phase_symmetry_new(memory, bytes, NULL, SLOW, &filters, &bank) != pointer;
    faults += bonebeam_phase_symmetry_new(memory, bytes - 1, slow, SLOW, &filters, &bank) != storage;
    bytes = bonebeam_phase_symmetry_slow_bytes(&filters);
    faults += bonebeam_phase_symmetry_new(memory, FAST, slow, bytes - 1, &filters, &bank) != storage;
    faults += bank != NULL;
    none(faults, "refusals are not as they should be");
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
    frames();
    stretches();
    overlaps();
    refusals();
    return 0;
}
