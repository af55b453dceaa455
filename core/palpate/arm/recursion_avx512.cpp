// The recursion with the 32 registers of AVX-512, which keep what AVX2 has to put away, and vectors of the same length.
// Compiled without contraction to FMA: its results are those of the portable build, bit by bit.
#include "palpate/arm/recursion.hpp"

#if defined(__x86_64__) && defined(__clang__)  // clang knows the width as an option of the command line alone
#define PALPATE_TARGET __attribute__((target("avx512f,avx512vl,avx512dq")))
#elif defined(__x86_64__)
#define PALPATE_TARGET __attribute__((target("avx512f,avx512vl,avx512dq,prefer-vector-width=256")))
#else
#define PALPATE_TARGET
#endif

namespace palpate::arm::avx512 {
#include "palpate/arm/recursion_body.inl"
}  // namespace palpate::arm::avx512

#undef PALPATE_TARGET
