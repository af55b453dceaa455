// The kernel for AVX2 and FMA. Only functions with PALPATE_TARGET may use these instructions. bvh_closest() calls the
// kernel only on processors that have them (bvh_query_portable.cpp).
#include <cstddef>
#include <cstdint>

#include "palpate/scene/bvh.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define PALPATE_TARGET __attribute__((target("avx2,fma")))

namespace palpate::scene {
namespace avx2 {
namespace {

#include "palpate/types/vectors_avx2.inl"
PALPATE_TARGET inline F8 operator<=(F8 a, F8 b) { return {_mm256_cmp_ps(a.x, b.x, _CMP_LE_OQ)}; }
PALPATE_TARGET inline F8 root(F8 a) { return {_mm256_sqrt_ps(a.x)}; }
PALPATE_TARGET inline unsigned mask_of(F8 a) { return static_cast<unsigned>(_mm256_movemask_ps(a.x)); }

struct D4 {
  __m256d x;
  PALPATE_TARGET static D4 all(double s) { return {_mm256_set1_pd(s)}; }
  PALPATE_TARGET static D4 load(const double* s) { return {_mm256_load_pd(s)}; }
  PALPATE_TARGET void store(double* s) const { _mm256_storeu_pd(s, x); }
};
PALPATE_TARGET inline D4 operator+(D4 a, D4 b) { return {_mm256_add_pd(a.x, b.x)}; }
PALPATE_TARGET inline D4 operator-(D4 a, D4 b) { return {_mm256_sub_pd(a.x, b.x)}; }
PALPATE_TARGET inline D4 operator*(D4 a, D4 b) { return {_mm256_mul_pd(a.x, b.x)}; }
PALPATE_TARGET inline D4 operator/(D4 a, D4 b) { return {_mm256_div_pd(a.x, b.x)}; }
PALPATE_TARGET inline D4 operator<(D4 a, D4 b) { return {_mm256_cmp_pd(a.x, b.x, _CMP_LT_OQ)}; }
PALPATE_TARGET inline D4 operator<=(D4 a, D4 b) { return {_mm256_cmp_pd(a.x, b.x, _CMP_LE_OQ)}; }
PALPATE_TARGET inline D4 operator&(D4 a, D4 b) { return {_mm256_and_pd(a.x, b.x)}; }
PALPATE_TARGET inline D4 select(D4 mask, D4 a, D4 b) { return {_mm256_blendv_pd(b.x, a.x, mask.x)}; }
PALPATE_TARGET inline unsigned mask_of(D4 a) { return static_cast<unsigned>(_mm256_movemask_pd(a.x)); }
/// A NaN becomes lo, because _mm256_max_pd returns its second operand for NaN.
PALPATE_TARGET inline D4 clamp(D4 a, D4 lo, D4 hi) { return {_mm256_min_pd(_mm256_max_pd(a.x, lo.x), hi.x)}; }
PALPATE_TARGET inline D4 dot(const D4 a[3], const D4 b[3]) {
  return {_mm256_fmadd_pd(a[0].x, b[0].x, _mm256_fmadd_pd(a[1].x, b[1].x, _mm256_mul_pd(a[2].x, b[2].x)))};
}

#include "palpate/scene/bvh_query.inl"

}  // namespace
}  // namespace avx2

PALPATE_TARGET BvhHit bvh_closest_avx2(const Bvh& bvh, const double p[3], const BvhHit& best,
                                       double exact_within) noexcept {
  return avx2::closest_in(bvh, p, best, exact_within);
}

bool bvh_has_avx2() noexcept {
  __builtin_cpu_init();  // needed because static initialisers may run before those of the compiler's library
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

}  // namespace palpate::scene

#else  // other processors use the portable kernel

namespace palpate::scene {

BvhHit bvh_closest_avx2(const Bvh& bvh, const double p[3], const BvhHit& best, double exact_within) noexcept {
  return bvh_closest_portable(bvh, p, best, exact_within);
}

bool bvh_has_avx2() noexcept { return false; }

}  // namespace palpate::scene

#endif
