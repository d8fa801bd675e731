#pragma once

// Functions compiled for several kinds of processor; the program chooses one when it starts.

/// RING_GYRO_VECTOR_CLONES marks a function to be compiled for several vector widths. Kernels of
/// the plant and the demodulator must do the same operations on each element whatever the width
/// (sums over fixed lanes, no contraction to fused multiply-add), so that the results are the same
/// to the last bit on every machine.
///
/// RING_GYRO_FUSED_CLONES marks a function to be compiled with and without fused multiply-add,
/// which halves the time of a chain of sums of products. Compilers that know the processor level
/// x86-64-v3, which has it, also use the other instructions of that level. Results differ by
/// rounding between machines with and without fused multiply-add.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RING_GYRO_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#if __GNUC__ >= 12
#define RING_GYRO_FUSED_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define RING_GYRO_FUSED_CLONES __attribute__((target_clones("fma", "default")))
#endif
#else
#define RING_GYRO_VECTOR_CLONES
#define RING_GYRO_FUSED_CLONES
#endif

/// Prevents inlining into a function that is compiled several times: for code that is seldom called
/// or is the same at any width.
#if defined(__GNUC__)
#define RING_GYRO_NOT_INLINE __attribute__((noinline))
#else
#define RING_GYRO_NOT_INLINE
#endif

/// Inlines everything that the marked function calls, so that it is compiled for the vector width
/// of that function.
#if defined(__GNUC__)
#define RING_GYRO_FLATTEN __attribute__((flatten))
#else
#define RING_GYRO_FLATTEN
#endif
