/* bonebeam for C. Made by cbindgen from bonebeam-c/src: do not edit.
 *
 * MIT OR Apache-2.0 */

#ifndef BONEBEAM_H
#define BONEBEAM_H

#include <stddef.h>
#include <stdint.h>

// Bytes of its storage.
#define BONEBEAM_16_8_SIZE 2432

// Alignment of its storage, bytes.
#define BONEBEAM_16_8_ALIGN 8

// Bytes of its storage.
#define BONEBEAM_32_16_SIZE 6720

// Alignment of its storage, bytes.
#define BONEBEAM_32_16_ALIGN 8

// Bytes of its storage.
#define BONEBEAM_64_32_SIZE 21504

// Alignment of its storage, bytes.
#define BONEBEAM_64_32_ALIGN 8

// Bytes of its storage.
#define BONEBEAM_128_64_SIZE 75648

// Alignment of its storage, bytes.
#define BONEBEAM_128_64_ALIGN 8

// Bytes of its storage.
#define BONEBEAM_FORWARD_32_16_SIZE 11456

// Alignment of its storage, bytes.
#define BONEBEAM_FORWARD_32_16_ALIGN 8

// Bytes of its storage.
#define BONEBEAM_DELAY_SIZE 10240

// Alignment of its storage, bytes.
#define BONEBEAM_DELAY_ALIGN 64

// Bytes of its storage.
#define BONEBEAM_IQ_SIZE 128

// Alignment of its storage, bytes.
#define BONEBEAM_IQ_ALIGN 8

// The most transmits that one line is compounded of.
#define BONEBEAM_IQ_WAVES 16

// Bytes of its storage.
#define BONEBEAM_IQ_LINES_SIZE 512

// Alignment of its storage, bytes.
#define BONEBEAM_IQ_LINES_ALIGN 8

// What a call came to. Only 0 leaves something in the outputs.
enum bonebeam_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done.
  BONEBEAM_STATUS_OK = 0,
  // A parameter is outside its range.
  BONEBEAM_STATUS_PARAMETER = 1,
  // An array has another length than the shapes ask for.
  BONEBEAM_STATUS_LENGTH = 2,
  // A size exceeds what there is room for.
  BONEBEAM_STATUS_CAPACITY = 3,
  // An input sample is NaN or infinite.
  BONEBEAM_STATUS_NON_FINITE = 4,
  // External memory could not be read or written.
  BONEBEAM_STATUS_MEMORY = 5,
  // A pointer is null or not aligned.
  BONEBEAM_STATUS_POINTER = 6,
  // The storage is smaller than its constant.
  BONEBEAM_STATUS_STORAGE = 7,
  // An error that this version has no number for.
  BONEBEAM_STATUS_OTHER = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_status bonebeam_status;
#else
typedef int32_t bonebeam_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How the transmit wave travels.
enum bonebeam_law
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // A focused beam: the line lies on its axis.
  BONEBEAM_LAW_FOCUSED = 0,
  // A plane wave at the angle `angle`.
  BONEBEAM_LAW_PLANE = 1,
  // One element, at `x`, `z`.
  BONEBEAM_LAW_ELEMENT = 2,
  // A wave that goes to the point at `x`, `z`, or comes from it where that lies behind the array, `z` ≤ 0.
  BONEBEAM_LAW_SOURCE = 3,
  // The first wave that arrives of elements that fire at `delays`.
  BONEBEAM_LAW_DELAYS = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_law bonebeam_law;
#else
typedef int32_t bonebeam_law;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// In which order samples of I/Q lie.
enum bonebeam_layout
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // `[element][sample]`, as recordings are.
  BONEBEAM_LAYOUT_PLANAR = 0,
  // `[sample][element]`, as a front end sends them.
  BONEBEAM_LAYOUT_INTERLEAVED = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_layout bonebeam_layout;
#else
typedef int32_t bonebeam_layout;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How decibels are worked out.
enum bonebeam_logarithm
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // By libm's logarithm.
  BONEBEAM_LOGARITHM_EXACT = 0,
  // By a polynomial: a third of the instructions, within the error that `Logarithm::Polynomial` in the core's
  // documentation states.
  BONEBEAM_LOGARITHM_POLYNOMIAL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_logarithm bonebeam_logarithm;
#else
typedef int32_t bonebeam_logarithm;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A beamformer's name.
enum bonebeam_method
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Delay and sum.
  BONEBEAM_METHOD_DAS = 0,
  // Minimum variance.
  BONEBEAM_METHOD_MV = 1,
  // Eigenspace MV, its rank by `beta`.
  BONEBEAM_METHOD_ESMV_BETA = 2,
  // Eigenspace MV of the rank `rank`.
  BONEBEAM_METHOD_ESMV_RANK = 3,
  // Eigenspace MV of rank 1.
  BONEBEAM_METHOD_ESMV_RANK1 = 4,
  // Eigenspace MV with all eigenvectors but the first.
  BONEBEAM_METHOD_ESMV_EXCLUDE_FIRST = 5,
  // Eigenspace MV of rank 1, its eigenvector by `steps` of power iteration, in constant time.
  BONEBEAM_METHOD_ESMV_RANK1_STEPS = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_method bonebeam_method;
#else
typedef int32_t bonebeam_method;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How I/Q is read between two samples. `IqReading::for_band` in the core's documentation says which is
// enough.
enum bonebeam_reading
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Along the line between the two.
  BONEBEAM_READING_LINEAR = 0,
  // Along the cubic through the two and their neighbours.
  BONEBEAM_READING_CUBIC = 1,
  // By a windowed sinc of 12 taps.
  BONEBEAM_READING_SINC = 2,
  // Along the line, in fixed point: of counts only. `IqReading::LinearFixed` in the core's documentation has
  // its limits.
  BONEBEAM_READING_LINEAR_FIXED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum bonebeam_reading bonebeam_reading;
#else
typedef int32_t bonebeam_reading;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A beamformer for up to 128 active elements, subapertures of up to 64 and time windows of up to 2·2 + 1 samples.
typedef struct bonebeam_128_64 bonebeam_128_64;

// A beamformer for up to 16 active elements, subapertures of up to 8 and time windows of up to 2·2 + 1 samples.
typedef struct bonebeam_16_8 bonebeam_16_8;

// A beamformer for up to 32 active elements, subapertures of up to 16 and time windows of up to 2·2 + 1 samples.
typedef struct bonebeam_32_16 bonebeam_32_16;

// A beamformer for up to 64 active elements, subapertures of up to 32 and time windows of up to 2·2 + 1 samples.
typedef struct bonebeam_64_32 bonebeam_64_32;

// A beamformer for up to 32 active elements, subapertures of up to 16 and time windows of up to 2·2 + 1 samples.
typedef struct bonebeam_forward_32_16 bonebeam_forward_32_16;

// A delay stage.
typedef struct bonebeam_delay bonebeam_delay;

// The lines of a scan: its delay stage, its apertures and its beamformer.
typedef struct bonebeam_iq_lines bonebeam_iq_lines;

// A delay stage for I/Q.
typedef struct bonebeam_iq bonebeam_iq;

// An aperture that grows with depth.
typedef struct bonebeam_aperture {
  // Elements of the array.
  size_t elements;
  // From one element to the next, m.
  double pitch;
  // Depth over width.
  double f_number;
  // Active at the least.
  size_t min_elements;
} bonebeam_aperture;

// Consecutive active elements.
typedef struct bonebeam_active {
  // The first of them.
  size_t first;
  // How many.
  size_t count;
} bonebeam_active;

// What a beamformer is asked for.
typedef struct bonebeam_beamform_parameters {
  // One of `bonebeam_method`, as a number: any other is refused.
  int32_t method;
  // Of `ESMV_BETA`, above 0 and at most 1.
  float beta;
  // Of `ESMV_RANK`, at least 1.
  size_t rank;
  // Of `ESMV_RANK1_STEPS`, 1 to 64.
  size_t steps;
  // `K`: the covariance is averaged over `2K + 1` samples.
  size_t temporal_half_window;
  // `Δ`, 0.05 for instance.
  float diagonal_loading;
  // The subaperture's share of the active elements, 0.5 for instance.
  double subaperture_ratio;
} bonebeam_beamform_parameters;

// A complex number.
typedef struct bonebeam_complex {
  // The real part.
  float re;
  // The imaginary part.
  float im;
} bonebeam_complex;

// Samples of a line: from `first` on, up to `end`, which is not one of them.
typedef struct bonebeam_samples {
  // The first.
  size_t first;
  // The one after the last.
  size_t end;
} bonebeam_samples;

// One transmit.
typedef struct bonebeam_wave {
  // One of `bonebeam_law`, as a number: any other is refused.
  int32_t law;
  // Of a plane wave, rad; positive towards positive x.
  double angle;
  // Of the transmitting element, or of the source, m.
  double x;
  // The same, depth, m.
  double z;
  // Of `DELAYS`: when each element fires, s, as many as the stage has elements; NaN for one that does not.
  const double *delays;
  // Time of record sample 0 from the moment the wave would pass the law's origin, s.
  double t0;
} bonebeam_wave;

// What the elements recorded of one transmit: counts of I and Q in turn, times `scale`.
typedef struct bonebeam_iq_wave {
  // How the wave travels.
  struct bonebeam_wave wave;
  // Elements · record samples pairs.
  const int16_t *counts;
  // What a count stands for.
  float scale;
  // One of `bonebeam_layout`, as a number: any other is refused.
  int32_t layout;
} bonebeam_iq_wave;

// The memory that a line is worked out in: of the lengths that `bonebeam_iq_lines_lengths` gives.
typedef struct bonebeam_line_memory {
  // How many samples are focused and beamformed at a time.
  size_t stretch;
  // Scratch memory.
  float *scratch;
  // Aligned samples.
  struct bonebeam_complex *aligned;
} bonebeam_line_memory;

// Shapes and rates of a delay stage. SI units.
typedef struct bonebeam_delay_parameters {
  // Speed of sound, m/s.
  double sound_speed;
  // Sampling rate of the record, Hz.
  double sampling_rate;
  // Centre frequency of the pulse, Hz.
  double centre_frequency;
  // Output rate, Hz, at least a sixteenth of the sampling rate.
  double output_rate;
  // Two-way time of output sample 0, s.
  double output_start;
  // Output samples.
  size_t output_samples;
  // Elements of the array.
  size_t elements;
  // Samples of each element's record.
  size_t record_samples;
  // Non-zero taps on one side of the Hilbert transformer, 8 for instance.
  size_t hilbert_taps;
} bonebeam_delay_parameters;

// An element: where it is, and where it looks.
typedef struct bonebeam_element {
  // Its lateral position, m.
  double x;
  // Its depth, m.
  double z;
  // The angle of its normal from straight down, rad; positive looks towards positive x.
  double angle;
} bonebeam_element;

// One scan line of one transmit.
typedef struct bonebeam_scan_line {
  // The transmit.
  struct bonebeam_wave wave;
  // Where the line leaves, m.
  double x;
  // The same, depth, m.
  double z;
  // Its angle from straight down, rad; positive towards positive x.
  double steering;
  // Of a linear array: lateral positions of the elements, m, ascending and evenly spaced; as many as the stage
  // has. Null for an array of another kind.
  const double *element_x;
  // Of another array: its elements along a line or an arc, from left to right; as many as the stage has.
  const struct bonebeam_element *elements;
  // From one of those to the next along the array, m.
  double pitch;
  // The elements to compute.
  struct bonebeam_active active;
  // Not 0: add to what the output holds, as the next of several transmits.
  int32_t add;
} bonebeam_scan_line;

// Evenly spaced positions: `first + k·step` for `k` below `count`.
typedef struct bonebeam_axis {
  // The position of index 0, m.
  double first;
  // From one index to the next, m; positive.
  double step;
  // How many positions there are.
  size_t count;
} bonebeam_axis;

// Shapes and rates of a delay stage for I/Q. SI units.
typedef struct bonebeam_iq_parameters {
  // Speed of sound, m/s.
  double sound_speed;
  // Sampling rate of the record, complex samples a second.
  double sampling_rate;
  // The frequency that the record was demodulated with, Hz.
  double demodulation_frequency;
  // Output rate, Hz.
  double output_rate;
  // Two-way time of output sample 0, s.
  double output_start;
  // Output samples.
  size_t output_samples;
  // Elements of the array.
  size_t elements;
  // Samples of each element's record.
  size_t record_samples;
  // One of `bonebeam_reading`, as a number: any other is refused.
  int32_t reading;
} bonebeam_iq_parameters;

// A scan of I/Q by a linear array that is centred on 0. SI units.
typedef struct bonebeam_iq_scan {
  // Elements of the array.
  size_t elements;
  // From one element to the next, m.
  double pitch;
  // Where the lines leave, straight down.
  struct bonebeam_axis lines;
  // Speed of sound, m/s.
  double sound_speed;
  // Centre frequency of the pulse, Hz.
  double centre_frequency;
  // Sampling rate of the record, complex samples a second.
  double sampling_rate;
  // Samples of each element's record.
  size_t record_samples;
  // The frequency that the record was demodulated with, Hz.
  double demodulation_frequency;
  // One of `bonebeam_reading`, as a number: any other is refused.
  int32_t reading;
  // Output rate, Hz.
  double output_rate;
  // Two-way time of a line's first sample, s.
  double start;
  // Two-way time that a line's last sample does not exceed, s.
  double end;
  // Depth over width of the aperture.
  double f_number;
  // Active elements at the least.
  size_t min_elements;
  // The least depth at which the beamformer works, m; 0 for both where it works everywhere.
  double gate_from;
  // The greatest: elsewhere is DAS.
  double gate_to;
} bonebeam_iq_scan;

// How long a line is, and the memory that it is worked out in.
typedef struct bonebeam_line_lengths {
  // Samples of a line.
  size_t samples;
  // Floats of scratch memory.
  size_t scratch;
  // Complex numbers of aligned samples.
  size_t aligned;
} bonebeam_line_lengths;

// How many floats of each kind of memory it takes.
typedef struct bonebeam_lengths {
  // Fast: what a strip reads, what it gives, a line and a filter's gains, all in one array.
  size_t fast;
  // Slow: spectrum, filtered image and the denominator, all in one array.
  size_t slow;
  // The map, as large as the image.
  size_t map;
} bonebeam_lengths;

// What phase symmetry is asked for.
typedef struct bonebeam_phase_symmetry_parameters {
  // Rows of the image: 64, 128, 256, 512 or 1024.
  size_t rows;
  // Columns of the image, likewise.
  size_t columns;
  // How many rows or columns are worked on at a time: memory, never the result.
  size_t strip;
  // The filters' centre frequencies r₀, cycles a pixel.
  const double *scales;
  // How many, 1 to 8.
  size_t scale_count;
  // The noise threshold T_n, grey levels.
  float threshold;
} bonebeam_phase_symmetry_parameters;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The active elements at each of `count` depths, m, below the place `beam`, in pitches from element 0.
//
// # Safety
// `aperture` leads to what it says, `depths` and `active` to `count` numbers.
bonebeam_status bonebeam_active_elements(const struct bonebeam_aperture *aperture,
                                         double beam,
                                         const double *depths,
                                         size_t count,
                                         struct bonebeam_active *active);

// Sets a beamformer up in storage of the caller's, which it lives in from then on.
//
// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
// storage that is too small or not aligned.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
bonebeam_status bonebeam_16_8_init(void *storage,
                                   size_t bytes,
                                   const struct bonebeam_beamform_parameters *parameters,
                                   struct bonebeam_16_8 **beamformer);

// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
// `active[n]`.
//
// Refuses a sample that is not finite, and active elements beyond the array or the
// beamformer's size. The scale is that of the input.
//
// # Safety
// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
// `samples`.
bonebeam_status bonebeam_16_8_line(struct bonebeam_16_8 *beamformer,
                                   const struct bonebeam_complex *x,
                                   size_t samples,
                                   size_t elements,
                                   const struct bonebeam_active *active,
                                   struct bonebeam_complex *z);

// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
// whole line, and the others by DAS. Only the active elements within need be as few as the
// beamformer's size.
//
// # Safety
// As for a whole line; `adaptive` leads to what it says.
bonebeam_status bonebeam_16_8_line_within(struct bonebeam_16_8 *beamformer,
                                          const struct bonebeam_complex *x,
                                          size_t samples,
                                          size_t elements,
                                          const struct bonebeam_active *active,
                                          const struct bonebeam_samples *adaptive,
                                          struct bonebeam_complex *z);

// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
// says, and may be changed in part where something is refused.
//
// # Safety
// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
// scan has; `memory` to its lengths, `z` to the line's samples.
bonebeam_status bonebeam_16_8_iq_line(struct bonebeam_16_8 *beamformer,
                                      const struct bonebeam_iq_lines *lines,
                                      size_t index,
                                      const struct bonebeam_iq_wave *waves,
                                      size_t count,
                                      const struct bonebeam_line_memory *memory,
                                      struct bonebeam_complex *z);

// Sets a beamformer up in storage of the caller's, which it lives in from then on.
//
// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
// storage that is too small or not aligned.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
bonebeam_status bonebeam_32_16_init(void *storage,
                                    size_t bytes,
                                    const struct bonebeam_beamform_parameters *parameters,
                                    struct bonebeam_32_16 **beamformer);

// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
// `active[n]`.
//
// Refuses a sample that is not finite, and active elements beyond the array or the
// beamformer's size. The scale is that of the input.
//
// # Safety
// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
// `samples`.
bonebeam_status bonebeam_32_16_line(struct bonebeam_32_16 *beamformer,
                                    const struct bonebeam_complex *x,
                                    size_t samples,
                                    size_t elements,
                                    const struct bonebeam_active *active,
                                    struct bonebeam_complex *z);

// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
// whole line, and the others by DAS. Only the active elements within need be as few as the
// beamformer's size.
//
// # Safety
// As for a whole line; `adaptive` leads to what it says.
bonebeam_status bonebeam_32_16_line_within(struct bonebeam_32_16 *beamformer,
                                           const struct bonebeam_complex *x,
                                           size_t samples,
                                           size_t elements,
                                           const struct bonebeam_active *active,
                                           const struct bonebeam_samples *adaptive,
                                           struct bonebeam_complex *z);

// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
// says, and may be changed in part where something is refused.
//
// # Safety
// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
// scan has; `memory` to its lengths, `z` to the line's samples.
bonebeam_status bonebeam_32_16_iq_line(struct bonebeam_32_16 *beamformer,
                                       const struct bonebeam_iq_lines *lines,
                                       size_t index,
                                       const struct bonebeam_iq_wave *waves,
                                       size_t count,
                                       const struct bonebeam_line_memory *memory,
                                       struct bonebeam_complex *z);

// Sets a beamformer up in storage of the caller's, which it lives in from then on.
//
// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
// storage that is too small or not aligned.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
bonebeam_status bonebeam_64_32_init(void *storage,
                                    size_t bytes,
                                    const struct bonebeam_beamform_parameters *parameters,
                                    struct bonebeam_64_32 **beamformer);

// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
// `active[n]`.
//
// Refuses a sample that is not finite, and active elements beyond the array or the
// beamformer's size. The scale is that of the input.
//
// # Safety
// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
// `samples`.
bonebeam_status bonebeam_64_32_line(struct bonebeam_64_32 *beamformer,
                                    const struct bonebeam_complex *x,
                                    size_t samples,
                                    size_t elements,
                                    const struct bonebeam_active *active,
                                    struct bonebeam_complex *z);

// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
// whole line, and the others by DAS. Only the active elements within need be as few as the
// beamformer's size.
//
// # Safety
// As for a whole line; `adaptive` leads to what it says.
bonebeam_status bonebeam_64_32_line_within(struct bonebeam_64_32 *beamformer,
                                           const struct bonebeam_complex *x,
                                           size_t samples,
                                           size_t elements,
                                           const struct bonebeam_active *active,
                                           const struct bonebeam_samples *adaptive,
                                           struct bonebeam_complex *z);

// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
// says, and may be changed in part where something is refused.
//
// # Safety
// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
// scan has; `memory` to its lengths, `z` to the line's samples.
bonebeam_status bonebeam_64_32_iq_line(struct bonebeam_64_32 *beamformer,
                                       const struct bonebeam_iq_lines *lines,
                                       size_t index,
                                       const struct bonebeam_iq_wave *waves,
                                       size_t count,
                                       const struct bonebeam_line_memory *memory,
                                       struct bonebeam_complex *z);

// Sets a beamformer up in storage of the caller's, which it lives in from then on.
//
// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
// storage that is too small or not aligned.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
bonebeam_status bonebeam_128_64_init(void *storage,
                                     size_t bytes,
                                     const struct bonebeam_beamform_parameters *parameters,
                                     struct bonebeam_128_64 **beamformer);

// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
// `active[n]`.
//
// Refuses a sample that is not finite, and active elements beyond the array or the
// beamformer's size. The scale is that of the input.
//
// # Safety
// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
// `samples`.
bonebeam_status bonebeam_128_64_line(struct bonebeam_128_64 *beamformer,
                                     const struct bonebeam_complex *x,
                                     size_t samples,
                                     size_t elements,
                                     const struct bonebeam_active *active,
                                     struct bonebeam_complex *z);

// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
// whole line, and the others by DAS. Only the active elements within need be as few as the
// beamformer's size.
//
// # Safety
// As for a whole line; `adaptive` leads to what it says.
bonebeam_status bonebeam_128_64_line_within(struct bonebeam_128_64 *beamformer,
                                            const struct bonebeam_complex *x,
                                            size_t samples,
                                            size_t elements,
                                            const struct bonebeam_active *active,
                                            const struct bonebeam_samples *adaptive,
                                            struct bonebeam_complex *z);

// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
// says, and may be changed in part where something is refused.
//
// # Safety
// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
// scan has; `memory` to its lengths, `z` to the line's samples.
bonebeam_status bonebeam_128_64_iq_line(struct bonebeam_128_64 *beamformer,
                                        const struct bonebeam_iq_lines *lines,
                                        size_t index,
                                        const struct bonebeam_iq_wave *waves,
                                        size_t count,
                                        const struct bonebeam_line_memory *memory,
                                        struct bonebeam_complex *z);

// Sets a beamformer up in storage of the caller's, which it lives in from then on.
//
// `*beamformer` becomes the pointer to use. Refuses parameters outside their ranges, and
// storage that is too small or not aligned.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `beamformer` lead to what they say.
bonebeam_status bonebeam_forward_32_16_init(void *storage,
                                            size_t bytes,
                                            const struct bonebeam_beamform_parameters *parameters,
                                            struct bonebeam_forward_32_16 **beamformer);

// Beamforms one beam: `z[n]` from `x[n·elements..]`, aligned analytic samples, with the elements
// `active[n]`.
//
// Refuses a sample that is not finite, and active elements beyond the array or the
// beamformer's size. The scale is that of the input.
//
// # Safety
// `beamformer` is from its init; `x` leads to `samples · elements` numbers, `active` and `z` to
// `samples`.
bonebeam_status bonebeam_forward_32_16_line(struct bonebeam_forward_32_16 *beamformer,
                                            const struct bonebeam_complex *x,
                                            size_t samples,
                                            size_t elements,
                                            const struct bonebeam_active *active,
                                            struct bonebeam_complex *z);

// The same within a depth gate: the samples `adaptive` by the beamformer's method, with the bits of the
// whole line, and the others by DAS. Only the active elements within need be as few as the
// beamformer's size.
//
// # Safety
// As for a whole line; `adaptive` leads to what it says.
bonebeam_status bonebeam_forward_32_16_line_within(struct bonebeam_forward_32_16 *beamformer,
                                                   const struct bonebeam_complex *x,
                                                   size_t samples,
                                                   size_t elements,
                                                   const struct bonebeam_active *active,
                                                   const struct bonebeam_samples *adaptive,
                                                   struct bonebeam_complex *z);

// Line `index` of a scan of I/Q, the mean over `count` transmits, by the beamformer that `lines` was set up
// with: of this one it takes the memory only. `z` gets as many samples as `bonebeam_iq_lines_lengths`
// says, and may be changed in part where something is refused.
//
// # Safety
// `beamformer` and `lines` are from their inits; `waves` leads to `count`, their counts to as many as the
// scan has; `memory` to its lengths, `z` to the line's samples.
bonebeam_status bonebeam_forward_32_16_iq_line(struct bonebeam_forward_32_16 *beamformer,
                                               const struct bonebeam_iq_lines *lines,
                                               size_t index,
                                               const struct bonebeam_iq_wave *waves,
                                               size_t count,
                                               const struct bonebeam_line_memory *memory,
                                               struct bonebeam_complex *z);

// Sets a delay stage up in storage of the caller's. `*delay` becomes the pointer to use.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `delay` lead to what they say.
bonebeam_status bonebeam_delay_init(void *storage,
                                    size_t bytes,
                                    const struct bonebeam_delay_parameters *parameters,
                                    struct bonebeam_delay **delay);

// `bonebeam_delay_init` with the filter worked out in single precision: a fiftieth of the instructions where
// doubles are computed in software. A line has other bits: `Delay::set_in_f32` in the core's documentation.
//
// # Safety
// As `bonebeam_delay_init`.
bonebeam_status bonebeam_delay_init_in_f32(void *storage,
                                           size_t bytes,
                                           const struct bonebeam_delay_parameters *parameters,
                                           struct bonebeam_delay **delay);

// The stage for other parameters. Filters are kept where rates, centre frequency and taps stay, so that another
// sound speed, range of depths or number of elements costs next to nothing. What is refused leaves it as it was.
//
// # Safety
// `delay` is from its init; `parameters` leads to what it says.
bonebeam_status bonebeam_delay_set(struct bonebeam_delay *delay,
                                   const struct bonebeam_delay_parameters *parameters);

// `bonebeam_delay_set` of a stage from `bonebeam_delay_init_in_f32`: its filter stays one in single precision.
//
// # Safety
// As `bonebeam_delay_set`.
bonebeam_status bonebeam_delay_set_in_f32(struct bonebeam_delay *delay,
                                          const struct bonebeam_delay_parameters *parameters);

// How many floats `bonebeam_delay_line` needs as scratch.
//
// # Safety
// `parameters` leads to what it says; null gives 0.
size_t bonebeam_delay_scratch(const struct bonebeam_delay_parameters *parameters);

// One scan line: `out[n · elements + m]`, the analytic sample of element `m` at output sample `n`.
//
// `rf` is `[element][record sample]`. Refuses samples that are not finite, and shapes that are not the
// stage's.
//
// # Safety
// `delay` is from its init. `rf` leads to elements · record samples, `scratch` to `scratch_length`
// floats, `out` to output samples · elements, the line's arrays to as many numbers as there are elements.
bonebeam_status bonebeam_delay_line(const struct bonebeam_delay *delay,
                                    const struct bonebeam_scan_line *line,
                                    const float *rf,
                                    float *scratch,
                                    size_t scratch_length,
                                    struct bonebeam_complex *out);

// `|z|` of `length` samples.
//
// # Safety
// `z` and `out` lead to `length` numbers.
bonebeam_status bonebeam_envelope(const struct bonebeam_complex *z, size_t length, float *out);

// The largest of `length` envelopes; 0 for a null pointer.
//
// # Safety
// `envelopes` leads to `length` numbers.
float bonebeam_largest(const float *envelopes, size_t length);

// Grey levels 0 to 255: decibels relative to `reference`, of which `dynamic_range` dB are shown.
// `logarithm`: one of `bonebeam_logarithm`, as a number; any other is refused.
//
// # Safety
// `envelopes` and `out` lead to `length` numbers.
bonebeam_status bonebeam_log_compression(int32_t logarithm,
                                         const float *envelopes,
                                         size_t length,
                                         float reference,
                                         float dynamic_range,
                                         float *out);

// Grey levels of lines, `[beam][sample]`, as pixels `[row][column]`; 0 beyond the lines.
//
// # Safety
// The axes lead to what they say; `levels` to beams · samples numbers, `out` to rows · columns.
bonebeam_status bonebeam_resample(const float *levels,
                                  const struct bonebeam_axis *beams,
                                  const struct bonebeam_axis *samples,
                                  const struct bonebeam_axis *rows,
                                  const struct bonebeam_axis *columns,
                                  float *out);

// The median of 3 × 3 pixels.
//
// # Safety
// `image` and `out` lead to rows · columns numbers.
bonebeam_status bonebeam_median(const float *image, size_t rows, size_t columns, float *out);

// Sets a delay stage for I/Q up in storage of the caller's. `*iq` becomes the pointer to use.
//
// # Safety
// `storage` leads to so many `bytes`; `parameters` and `iq` lead to what they say.
bonebeam_status bonebeam_iq_init(void *storage,
                                 size_t bytes,
                                 const struct bonebeam_iq_parameters *parameters,
                                 struct bonebeam_iq **iq);

// How many floats `bonebeam_iq_line` and `bonebeam_iq_line_counts` need as scratch.
//
// # Safety
// `parameters` leads to what it says; null gives 0.
size_t bonebeam_iq_scratch(const struct bonebeam_iq_parameters *parameters);

// One scan line: `out[n · elements + m]`, the analytic sample of element `m` at output sample `n`.
//
// `iq` lies as `layout` says, one of `bonebeam_layout`. Refuses samples that are not finite, and shapes
// that are not the stage's.
//
// # Safety
// `stage` is from its init. `iq` leads to elements · record samples, `scratch` to `scratch_length` floats,
// `out` to output samples · elements, `line->element_x` to as many as there are elements.
bonebeam_status bonebeam_iq_line(const struct bonebeam_iq *stage,
                                 const struct bonebeam_scan_line *line,
                                 const struct bonebeam_complex *iq,
                                 int32_t layout,
                                 float *scratch,
                                 size_t scratch_length,
                                 struct bonebeam_complex *out);

// The same of counts of 16 bits as a front end sends them, I before Q; a count is `scale`.
//
// # Safety
// As [`bonebeam_iq_line`]; `counts` leads to twice as many numbers as there are samples.
bonebeam_status bonebeam_iq_line_counts(const struct bonebeam_iq *stage,
                                        const struct bonebeam_scan_line *line,
                                        const int16_t *counts,
                                        float scale,
                                        int32_t layout,
                                        float *scratch,
                                        size_t scratch_length,
                                        struct bonebeam_complex *out);

// Sets the lines of a scan up in storage of the caller's. `*lines` becomes the pointer to use.
//
// # Safety
// `storage` leads to so many `bytes`; `scan`, `beamformer` and `lines` lead to what they say.
bonebeam_status bonebeam_iq_lines_init(void *storage,
                                       size_t bytes,
                                       const struct bonebeam_iq_scan *scan,
                                       const struct bonebeam_beamform_parameters *beamformer,
                                       struct bonebeam_iq_lines **lines);

// The lengths for lines that are worked out `stretch` samples at a time: it changes memory and time, never a
// line. All 0 where `lines` is null.
//
// # Safety
// `lines` is from its init.
struct bonebeam_line_lengths bonebeam_iq_lines_lengths(const struct bonebeam_iq_lines *lines,
                                                       size_t stretch);

// The memory that phase symmetry takes; all 0 where the parameters are null.
//
// # Safety
// `parameters` leads to what it says.
struct bonebeam_lengths bonebeam_phase_symmetry_lengths(const struct bonebeam_phase_symmetry_parameters *parameters);

// The map of an image 0 to 255, `[row][column]`: at least 0 and below 1.
//
// `fast` and `slow` have the lengths of
// `bonebeam_phase_symmetry_lengths`; their contents are irrelevant.
//
// # Safety
// `parameters->scales` leads to `scale_count` numbers; `image` and `map` to
// rows · columns; `fast` and `slow` to their lengths.
bonebeam_status bonebeam_phase_symmetry(const struct bonebeam_phase_symmetry_parameters *parameters,
                                        const float *image,
                                        float *fast,
                                        float *slow,
                                        float *map);

// The elements of a convex array, `pitch` m apart along an arc of `radius` m whose middle is at x = 0, z = 0.
//
// # Safety
// `elements` leads to `count` of them.
bonebeam_status bonebeam_convex_array(double pitch,
                                      double radius,
                                      struct bonebeam_element *elements,
                                      size_t count);

// Lets a line leave along the array's normal at `place`, in elements from element 0: its `x`, `z` and
// `steering`, from its `elements` and `pitch`.
//
// # Safety
// `line` leads to a line, its `elements` to `count` of them.
bonebeam_status bonebeam_normal(struct bonebeam_scan_line *line,
                                size_t count,
                                double place);

// What a status means, in English; for logs. Any number may be asked for.
const char *bonebeam_status_text(int32_t status);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BONEBEAM_H */
