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
PALPATE_TARGET inline void load_rows(const float* u, const std::uint32_t row[kWide], __m256 r[4]) {
  for (int i = 0; i < 4; ++i)
    r[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(u + row[i])), _mm_load_ps(u + row[i + 4]), 1);
}

/// The four numbers of the first corners, and the differences of those of the other corners from them, by component.
PALPATE_TARGET inline void gather(const float* u, const std::uint32_t row[4][kWide], F8 first[4], F8 other[3][4]) {
  __m256 r0[4];
  load_rows(u, row[0], r0);
  for (int k = 0; k < 3; ++k) {
    __m256 r[4];
    load_rows(u, row[k + 1], r);
    for (int i = 0; i < 4; ++i) r[i] = _mm256_sub_ps(r[i], r0[i]);
    transpose(r);
    for (int i = 0; i < 4; ++i) other[k][i].x = r[i];
  }
  transpose(r0);
  for (int i = 0; i < 4; ++i) first[i].x = r0[i];
}

/// Adds four numbers to those of a node, or takes them away.
PALPATE_TARGET inline void add_to(float* to, __m128 x) { _mm_store_ps(to, _mm_add_ps(_mm_load_ps(to), x)); }
PALPATE_TARGET inline void take_from(float* to, __m128 x) { _mm_store_ps(to, _mm_sub_ps(_mm_load_ps(to), x)); }

/// Takes forces from the corners 1 to 3 and adds their sum to the first, one node after the other, because a node may
/// occur more than once.
PALPATE_TARGET inline void scatter(const F8 f[3][3], const std::uint32_t row[4][kWide], float* force) {
  __m256 sum[4] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
  for (int k = 0; k < 3; ++k) {
    __m256 r[4] = {f[k][0].x, f[k][1].x, f[k][2].x, _mm256_setzero_ps()};
    transpose(r);
    for (int i = 0; i < 4; ++i) {
      sum[i] = _mm256_add_ps(sum[i], r[i]);
      take_from(force + row[k + 1][i], _mm256_castps256_ps128(r[i]));
      take_from(force + row[k + 1][i + 4], _mm256_extractf128_ps(r[i], 1));
    }
  }
  for (int i = 0; i < 4; ++i) {
    add_to(force + row[0][i], _mm256_castps256_ps128(sum[i]));
    add_to(force + row[0][i + 4], _mm256_extractf128_ps(sum[i], 1));
  }
}

#include "palpate/tissue/elements.inl"

PALPATE_TARGET void dilatation(ElementArrays& a) noexcept { dilatation_in(a); }
PALPATE_TARGET void forces(ElementArrays& a) noexcept { forces_in(a); }

}  // namespace
}  // namespace avx2

Kernel avx2_kernel() noexcept { return {&avx2::dilatation, &avx2::forces}; }

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
