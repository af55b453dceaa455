// The element kernels, written once for a vector of eight floats, F8. It is included only by elements_avx2.cpp and
// elements_portable.cpp, each inside its own namespace and after the definitions of F8, its functions and
// PALPATE_TARGET.

constexpr float kFolded = 0.3F;    // J below which the barrier against inversion acts
constexpr float kBarrier = 40.0F;  // its modulus over that of the tetrahedron's own share: 4 k

/// Displacement gradient of eight tetrahedra with its invariants.
struct Strain {
  F8 H[3][3], cofactor[3][3];
  F8 trace, second, det;  // tr H, tr cof H, det H

  [[nodiscard]] PALPATE_TARGET F8 volume_change() const { return trace + second + det; }
};

/// pressure: of the nodes, mean of the four corners [Pa].
PALPATE_TARGET inline Strain strain_of(const ElementBlock& block, const float* u, F8& pressure) {
  F8 first[4], d[3][4], g[9];
  gather(u, block.row, first, d);
  pressure = mad(d[0][3] + d[1][3] + d[2][3], F8::all(0.25F), first[3]);
  for (int k = 0; k < 9; ++k) g[k] = F8::load(block.slope[k]);
  Strain s;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s.H[i][j] = mad(d[0][i], g[j], mad(d[1][i], g[3 + j], d[2][i] * g[6 + j]));
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      s.cofactor[i][j] = minus_product(s.H[i1][j1] * s.H[i2][j2], s.H[i1][j2], s.H[i2][j1]);
    }
  }
  s.trace = s.H[0][0] + s.H[1][1] + s.H[2][2];
  s.second = s.cofactor[0][0] + s.cofactor[1][1] + s.cofactor[2][2];
  s.det = mad(s.H[0][0], s.cofactor[0][0], mad(s.H[0][1], s.cofactor[0][1], s.H[0][2] * s.cofactor[0][2]));
  return s;
}

PALPATE_TARGET inline void dilatation_in(ElementArrays& a) {
  const F8 quarter = F8::all(0.25F);
  F8 unused;
  for (std::size_t b = 0; b < a.count; ++b) {
    const ElementBlock& block = a.blocks[b];
    const F8 change = strain_of(block, a.u, unused).volume_change();
    (change * (F8::load(block.volume) * quarter)).store(a.dilatation + b * kWide);
  }
}

/// Stress S / mu of the terms with mu, without stiffening: (2E - tr(2E) I - cof(2E) + (J - 1) I) / J; xx yy zz yz xz
/// xy.
PALPATE_TARGET inline void unit_stress(const Strain& s, const F8& change, F8 out[6]) {
  F8 e[6];  // 2E = H + H^T + H^T H
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int k = 0; k < 6; ++k) {
    const int i = row[k], j = column[k];
    e[k] = mad(s.H[0][i], s.H[0][j], mad(s.H[1][i], s.H[1][j], mad(s.H[2][i], s.H[2][j], s.H[i][j] + s.H[j][i])));
  }
  const F8 c[6] = {minus_product(e[1] * e[2], e[3], e[3]), minus_product(e[0] * e[2], e[4], e[4]),
                   minus_product(e[0] * e[1], e[5], e[5]), minus_product(e[4] * e[5], e[0], e[3]),
                   minus_product(e[3] * e[5], e[1], e[4]), minus_product(e[3] * e[4], e[2], e[5])};
  const F8 both = change - (e[0] + e[1] + e[2]);
  const F8 per_volume = reciprocal(max(F8::all(1.0F) + change, F8::all(0.2F)));  // bounded for inverted tetrahedra
  for (int k = 0; k < 6; ++k) out[k] = (k < 3 ? both + e[k] - c[k] : e[k] - c[k]) * per_volume;
}

/// Stress of the Prony terms over the shear modulus. It advances the memory and adds the energy of the terms, over the
/// shear modulus and times 4, to `energy`.
PALPATE_TARGET inline void viscous_stress(const Strain& s, const F8& change, const F8& stiffening,
                                          const Viscosity& viscosity, HistoryBlock* history, F8 sum[6], F8& energy) {
  F8 stress[6];
  unit_stress(s, change, stress);
  for (int k = 0; k < 6; ++k) {
    stress[k] = stress[k] * stiffening;
    sum[k] = F8::all(0.0F);
  }
  for (int t = 0; t < viscosity.terms; ++t) {
    const F8 share = F8::all(viscosity.share[t]), recover = F8::all(viscosity.recover[t]);
    F8 diagonal = F8::all(0.0F), mixed = diagonal;
    for (int k = 0; k < 6; ++k) {
      const F8 q = F8::load(history[t].q[k]), over = stress[k] - q;
      sum[k] = mad(share, over, sum[k]);
      F8& square = k < 3 ? diagonal : mixed;
      square = mad(over, over, square);
      mad(recover, over, q).store(history[t].q[k]);
    }
    energy = mad(share, diagonal + mixed + mixed, energy);
  }
}

/// First Piola-Kirchhoff stress times volume: mu V (1 + 2 c w) (F - cof F) + p V cof F + F S of the Prony terms.
/// scale: mu V (1 + 2 c w); pressure: p V; sum: S V of the Prony terms, null without them.
PALPATE_TARGET inline void full_stress(const Strain& s, const F8& scale, const F8& pressure, const F8* sum,
                                       F8 P[3][3]) {
  const F8 volumetric = pressure - scale, all = mad(volumetric, s.trace, pressure);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P[i][j] = volumetric * (s.cofactor[i][j] - s.H[j][i]);
  for (int i = 0; i < 3; ++i) P[i][i] = P[i][i] + all;
  if (sum == nullptr) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) P[i][j] = mad(scale, s.H[i][j], P[i][j]);
    return;
  }
  const F8 S[6] = {sum[0] + scale, sum[1] + scale, sum[2] + scale, sum[3], sum[4], sum[5]};
  const int at[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P[i][j] = mad(s.H[i][0], S[at[0][j]],
                    mad(s.H[i][1], S[at[1][j]], mad(s.H[i][2], S[at[2][j]], P[i][j] + sum[at[i][j]])));
}

PALPATE_TARGET inline void forces_in(ElementArrays& a) {
  const F8 one = F8::all(1.0F), two = F8::all(2.0F), half = F8::all(0.5F), zero = F8::all(0.0F);
  F8 energy = zero, least = one;
  for (std::size_t b = 0; b < a.count; ++b) {
    const ElementBlock& block = a.blocks[b];
    F8 corners;
    const Strain s = strain_of(block, a.u, corners);
    const F8 change = s.volume_change(), shear = F8::load(block.shear), c = F8::load(block.yeoh);
    F8 square = zero;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) square = mad(s.H[i][j], s.H[i][j], square);
    const F8 w = square - two * (s.second + s.det), stretch = max(w, zero);
    const F8 stiffening = mad(two * c, stretch, one);
    const F8 bulk = F8::load(block.bulk), below = min(change + F8::all(1.0F - kFolded), zero);
    const F8 barrier = F8::all(kBarrier) * below;
    const F8 pressure = mad(F8::load(block.volume), corners, bulk * (change + barrier));
    const F8 compressed = bulk * mad(barrier, below, change * change);
    energy = mad(half * shear, mad(c * stretch, stretch, w), mad(half, compressed, energy));
    least = min(least, one + change);

    F8 P[3][3];
    if (a.viscosity.terms > 0) {
      F8 sum[6], quarters = zero;
      viscous_stress(s, change, stiffening, a.viscosity, a.history + b * static_cast<std::size_t>(a.viscosity.terms),
                     sum, quarters);
      for (F8& x : sum) x = x * shear;
      energy = mad(F8::all(0.25F) * shear, quarters, energy);
      full_stress(s, shear * stiffening, pressure, sum, P);
    } else {
      full_stress(s, shear * stiffening, pressure, nullptr, P);
    }

    F8 f[3][3];
    for (int k = 0; k < 3; ++k) {
      const F8 g0 = F8::load(block.slope[3 * k]), g1 = F8::load(block.slope[3 * k + 1]),
               g2 = F8::load(block.slope[3 * k + 2]);
      for (int i = 0; i < 3; ++i) f[k][i] = mad(P[i][0], g0, mad(P[i][1], g1, P[i][2] * g2));
    }
    scatter(f, block.row, a.force);
  }
  float lanes[kWide];
  energy.store(lanes);
  a.shear_energy = 0.0;
  for (const float x : lanes) a.shear_energy += static_cast<double>(x);
  least.store(lanes);
  a.least_volume = static_cast<double>(lanes[0]);
  for (const float x : lanes)
    a.least_volume = static_cast<double>(x) < a.least_volume ? static_cast<double>(x) : a.least_volume;
}
