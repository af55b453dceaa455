// The element kernels, written once for a vector of eight floats, F8. It is included only by elements_avx2.cpp and
// elements_portable.cpp, each inside its own namespace and after the definitions of F8, its functions and PALPATE_TARGET.

/// Displacement gradient of eight tetrahedra with its invariants.
struct Strain {
  F8 H[3][3], cofactor[3][3];
  F8 trace, second, det;  // tr H, tr cof H, det H

  [[nodiscard]] PALPATE_TARGET F8 volume_change() const { return trace + second + det; }
};

PALPATE_TARGET inline Strain strain_of(const ElementBlock& block, const float* u) {
  F8 first[3], d[3][3], g[9];
  gather(u, block.node[0], first);
  for (int k = 0; k < 3; ++k) {
    gather(u, block.node[k + 1], d[k]);
    for (int i = 0; i < 3; ++i) d[k][i] = d[k][i] - first[i];
  }
  for (int k = 0; k < 9; ++k) g[k] = F8::load(block.slope[k]);
  Strain s;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s.H[i][j] = mad(d[0][i], g[j], mad(d[1][i], g[3 + j], d[2][i] * g[6 + j]));
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      s.cofactor[i][j] = mad(s.H[i1][j1], s.H[i2][j2], negative(s.H[i1][j2] * s.H[i2][j1]));
    }
  }
  s.trace = s.H[0][0] + s.H[1][1] + s.H[2][2];
  s.second = s.cofactor[0][0] + s.cofactor[1][1] + s.cofactor[2][2];
  s.det = mad(s.H[0][0], s.cofactor[0][0], mad(s.H[0][1], s.cofactor[0][1], s.H[0][2] * s.cofactor[0][2]));
  return s;
}

PALPATE_TARGET inline void dilatation_in(ElementArrays& a) {
  const F8 quarter = F8::all(0.25F);
  for (std::size_t b = 0; b < a.count; ++b) {
    const ElementBlock& block = a.blocks[b];
    float value[kWide];
    (strain_of(block, a.u).volume_change() * F8::load(block.volume) * quarter).store(value);
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < kWide; ++i) a.dilatation[block.node[k][i]] += value[i];
  }
}

/// Stress S / mu of the terms with mu, without stiffening: (2E - tr(2E) I - cof(2E) + (J - 1) I) / J; xx yy zz yz xz xy.
PALPATE_TARGET inline void unit_stress(const Strain& s, const F8& change, F8 out[6]) {
  F8 e[6];  // 2E = H + H^T + H^T H
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int k = 0; k < 6; ++k) {
    const int i = row[k], j = column[k];
    e[k] = mad(s.H[0][i], s.H[0][j], mad(s.H[1][i], s.H[1][j], mad(s.H[2][i], s.H[2][j], s.H[i][j] + s.H[j][i])));
  }
  const F8 c[6] = {mad(e[1], e[2], negative(e[3] * e[3])), mad(e[0], e[2], negative(e[4] * e[4])),
                   mad(e[0], e[1], negative(e[5] * e[5])), mad(e[4], e[5], negative(e[0] * e[3])),
                   mad(e[3], e[5], negative(e[1] * e[4])), mad(e[3], e[4], negative(e[2] * e[5]))};
  const F8 both = change - (e[0] + e[1] + e[2]);
  const F8 per_volume = reciprocal(max(F8::all(1.0F) + change, F8::all(0.2F)));  // bounded for inverted tetrahedra
  for (int k = 0; k < 6; ++k) out[k] = (k < 3 ? both + e[k] - c[k] : e[k] - c[k]) * per_volume;
}

/// Adds the viscous stress to the first Piola-Kirchhoff stress P (both times volume), advances the memory, and returns
/// the energy of the Prony springs.
PALPATE_TARGET inline F8 add_viscous(const Strain& s, const F8& change, const F8& shear, const F8& stiffening,
                                     const Viscosity& viscosity, HistoryBlock* history, F8 P[3][3]) {
  F8 stress[6], sum[6], energy = F8::all(0.0F);
  unit_stress(s, change, stress);
  const F8 scale = shear * stiffening;
  for (int k = 0; k < 6; ++k) {
    stress[k] = stress[k] * scale;
    sum[k] = F8::all(0.0F);
  }
  for (int t = 0; t < viscosity.terms; ++t) {
    const F8 share = F8::all(viscosity.share[t]), recover = F8::all(viscosity.recover[t]);
    F8 square = F8::all(0.0F);
    for (int k = 0; k < 6; ++k) {
      const F8 q = F8::load(history[t].q[k]), over = stress[k] - q;
      sum[k] = mad(share, over, sum[k]);
      square = mad(over * F8::all(k < 3 ? 1.0F : 2.0F), over, square);
      mad(recover, over, q).store(history[t].q[k]);
    }
    energy = mad(share, square, energy);
  }
  const int at[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P[i][j] = P[i][j] + mad(s.H[i][0], sum[at[0][j]],
                              mad(s.H[i][1], sum[at[1][j]], mad(s.H[i][2], sum[at[2][j]], sum[at[i][j]])));
  return energy * F8::all(0.25F) * reciprocal(max(shear, F8::all(1e-30F)));
}

PALPATE_TARGET inline void forces_in(ElementArrays& a) {
  const F8 one = F8::all(1.0F), two = F8::all(2.0F), half = F8::all(0.5F), zero = F8::all(0.0F);
  F8 energy = zero, least = one;
  for (std::size_t b = 0; b < a.count; ++b) {
    const ElementBlock& block = a.blocks[b];
    const Strain s = strain_of(block, a.u);
    const F8 change = s.volume_change(), shear = F8::load(block.shear), c = F8::load(block.yeoh);
    F8 square = zero;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) square = mad(s.H[i][j], s.H[i][j], square);
    const F8 w = square - two * (s.second + s.det), stretch = max(w, zero);
    const F8 stiffening = mad(two * c, stretch, one), scale = shear * stiffening;
    const F8 own = F8::load(block.bulk) * change;
    const F8 pressure = own + F8::load(block.volume) * mean_of_corners(a.pressure, block.node);
    energy = mad(half * shear, mad(c * stretch, stretch, w), mad(half * own, change, energy));
    least = min(least, one + change);

    F8 P[3][3];  // P V = mu V (1 + 2 c w) (F - cof F) + p V cof F
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const F8 shape = s.H[i][j] + s.H[j][i] - s.cofactor[i][j], turned = s.cofactor[i][j] - s.H[j][i];
        P[i][j] = i == j ? mad(scale, shape - s.trace, pressure * (one + s.trace + turned))
                         : mad(scale, shape, pressure * turned);
      }
    if (a.viscosity.terms > 0)
      energy = energy + add_viscous(s, change, shear, stiffening, a.viscosity,
                                    a.history + b * static_cast<std::size_t>(a.viscosity.terms), P);

    F8 f[4][3];
    for (int i = 0; i < 3; ++i) f[0][i] = zero;
    for (int k = 0; k < 3; ++k) {
      const F8 g0 = F8::load(block.slope[3 * k]), g1 = F8::load(block.slope[3 * k + 1]),
               g2 = F8::load(block.slope[3 * k + 2]);
      for (int i = 0; i < 3; ++i) {
        const F8 inner = mad(P[i][0], g0, mad(P[i][1], g1, P[i][2] * g2));
        f[k + 1][i] = negative(inner);
        f[0][i] = f[0][i] + inner;
      }
    }
    for (int k = 0; k < 4; ++k) scatter_add(f[k], block.node[k], a.force);
  }
  float lanes[kWide];
  energy.store(lanes);
  a.shear_energy = 0.0;
  for (const float x : lanes) a.shear_energy += static_cast<double>(x);
  least.store(lanes);
  a.least_volume = static_cast<double>(lanes[0]);
  for (const float x : lanes) a.least_volume = static_cast<double>(x) < a.least_volume ? static_cast<double>(x) : a.least_volume;
}
