// Numbers of all joints as plain arrays of one length, zero beyond the last joint. Loops over them have fixed bounds,
// so that compilers unroll them and use vector instructions.
#pragma once

namespace palpate {

inline constexpr int kLanes = 8;
using Lanes = double[kLanes];

/// Rows of the identity.
alignas(64) inline constexpr Lanes kUnit[kLanes] = {{1},
                                                    {0, 1},
                                                    {0, 0, 1},
                                                    {0, 0, 0, 1},
                                                    {0, 0, 0, 0, 1},
                                                    {0, 0, 0, 0, 0, 1},
                                                    {0, 0, 0, 0, 0, 0, 1},
                                                    {0, 0, 0, 0, 0, 0, 0, 1}};

}  // namespace palpate

/// Compiles a function of plain loops twice, with and without AVX2; the loader chooses. The operations and their order
/// are the same, so that both return the same bits. Not for the fuzz targets: a sanitizer instruments the function that
/// chooses, and the loader calls it before the sanitizer's own functions have addresses. Not for clang, which wants the
/// attribute at every declaration of a function, in headers too: it compiles the plain version alone.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(PALPATE_FUZZ)
#define PALPATE_AVX2_TOO __attribute__((target_clones("avx2", "default")))
#else
#define PALPATE_AVX2_TOO
#endif
