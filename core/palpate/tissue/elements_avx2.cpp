// The kernels for AVX2 and FMA. Only functions with PALPATE_TARGET may use these instructions. A body
// selects its kernels (body_build.cpp).
#include <cstddef>
#include <cstdint>

#include "palpate/tissue/elements.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define PALPATE_TARGET __attribute__((target("avx2,fma")))

namespace palpate::tissue {
namespace avx2 {
namespace {

#include "palpate/types/vectors_avx2.inl"
PALPATE_TARGET inline F8 mad(F8 a, F8 b, F8 c) { return {_mm256_fmadd_ps(a.x, b.x, c.x)}; }
PALPATE_TARGET inline F8 minus_product(F8 a, F8 b, F8 c) { return {_mm256_fnmadd_ps(b.x, c.x, a.x)}; }  // a - b c
PALPATE_TARGET inline F8 min(F8 a, F8 b) { return {_mm256_min_ps(a.x, b.x)}; }
PALPATE_TARGET inline F8 reciprocal(F8 a) { return {_mm256_div_ps(_mm256_set1_ps(1.0F), a.x)}; }
PALPATE_TARGET inline F8 root(F8 a) { return {_mm256_sqrt_ps(a.x)}; }

/// Transposes four rows of four numbers in each half of the registers.
PALPATE_TARGET inline void transpose(__m256 r[4]) {
  const __m256 t0 = _mm256_unpacklo_ps(r[0], r[1]), t1 = _mm256_unpackhi_ps(r[0], r[1]);
  const __m256 t2 = _mm256_unpacklo_ps(r[2], r[3]), t3 = _mm256_unpackhi_ps(r[2], r[3]);
  r[0] = _mm256_shuffle_ps(t0, t2, 0x44);
  r[1] = _mm256_shuffle_ps(t0, t2, 0xEE);
  r[2] = _mm256_shuffle_ps(t1, t3, 0x44);
  r[3] = _mm256_shuffle_ps(t1, t3, 0xEE);
}

/// Rows of four numbers of eight nodes: those of nodes i and i + 4 in the halves of row i.
struct Rows {
  __m256 r[4];
};
PALPATE_TARGET inline Rows load_rows(const float* u, const std::uint32_t row[kWide]) {
  Rows out;
  for (int i = 0; i < 4; ++i)
    out.r[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(u + row[i])), _mm_load_ps(u + row[i + 4]), 1);
  return out;
}

/// Differences of the first three numbers of eight nodes from those of others, by component.
PALPATE_TARGET inline void differences(const float* u, const std::uint32_t row[kWide], const Rows& from, F8 out[3]) {
  Rows rows = load_rows(u, row);
  for (int i = 0; i < 4; ++i) rows.r[i] = _mm256_sub_ps(rows.r[i], from.r[i]);
  transpose(rows.r);
  for (int i = 0; i < 3; ++i) out[i].x = rows.r[i];
}

/// Adds to the numbers of eight nodes, one after the other.
PALPATE_TARGET inline void add_to_rows(const F8 x[3], const std::uint32_t row[kWide], float* to) {
  __m256 r[4] = {x[0].x, x[1].x, x[2].x, _mm256_setzero_ps()};
  transpose(r);
  for (int i = 0; i < 4; ++i) {
    float* const low = to + row[i];
    _mm_store_ps(low, _mm_add_ps(_mm_load_ps(low), _mm256_castps256_ps128(r[i])));
    float* const high = to + row[i + 4];
    _mm_store_ps(high, _mm_add_ps(_mm_load_ps(high), _mm256_extractf128_ps(r[i], 1)));
  }
}

#include "palpate/tissue/elements.inl"

PALPATE_TARGET void forces(const ElementList& list, NodeArrays& nodes) noexcept { forces_in(list, nodes); }

}  // namespace
}  // namespace avx2

Kernel avx2_kernel() noexcept { return &avx2::forces; }

bool has_avx2() noexcept {
  __builtin_cpu_init();  // needed because static initialisers may run before those of the compiler's library
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

}  // namespace palpate::tissue

#else  // other processors use the portable kernels

namespace palpate::tissue {

Kernel avx2_kernel() noexcept { return portable_kernel(); }
bool has_avx2() noexcept { return false; }

}  // namespace palpate::tissue

#endif
