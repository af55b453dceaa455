// F8, eight floats of AVX2 with element-wise operators. Included by the kernels for AVX2 alone, each inside its own
// namespace, after immintrin.h and the definition of PALPATE_TARGET.

struct F8 {
  __m256 x;
  PALPATE_TARGET static F8 all(float s) { return {_mm256_set1_ps(s)}; }
  PALPATE_TARGET static F8 load(const float* s) { return {_mm256_load_ps(s)}; }
  PALPATE_TARGET void store(float* s) const { _mm256_storeu_ps(s, x); }
};
PALPATE_TARGET inline F8 operator+(F8 a, F8 b) { return {_mm256_add_ps(a.x, b.x)}; }
PALPATE_TARGET inline F8 operator-(F8 a, F8 b) { return {_mm256_sub_ps(a.x, b.x)}; }
PALPATE_TARGET inline F8 operator*(F8 a, F8 b) { return {_mm256_mul_ps(a.x, b.x)}; }
PALPATE_TARGET inline F8 max(F8 a, F8 b) { return {_mm256_max_ps(a.x, b.x)}; }
