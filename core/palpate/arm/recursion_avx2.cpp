// The recursion with AVX2 instructions. Without FMA: its results are those of the portable build, bit by bit.
#include "palpate/arm/recursion.hpp"

#if defined(__x86_64__)
#define PALPATE_TARGET __attribute__((target("avx2")))
#else
#define PALPATE_TARGET
#endif

namespace palpate::arm::avx2 {
#include "palpate/arm/recursion_body.inl"
}  // namespace palpate::arm::avx2

#undef PALPATE_TARGET
