// The element kernels, written once for a vector of eight floats, F8. It is included only by elements_avx2.cpp and
// elements_portable.cpp, each inside its own namespace and after the definitions of PALPATE_TARGET, F8 and its functions,
// Rows, differences and add_to_rows.

constexpr float kFolded = 0.3F;  // J below which the barrier against inversion acts

/// Displacement gradient H of eight tetrahedra or patches with its invariants.
struct Strain {
  F8 H[3][3], cofactor[3][3];
  F8 trace, second, det;  // tr H, tr cof H, det H

  [[nodiscard]] PALPATE_TARGET F8 volume_change() const { return trace + second + det; }
};

/// Completes the invariants of H.
PALPATE_TARGET inline void find_invariants(Strain& s) {
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
}

/// A symmetric matrix, xx yy zz yz xz xy.
struct Symmetric {
  F8 x[6];
};
PALPATE_TARGET inline F8 trace_of(const Symmetric& a) { return a.x[0] + a.x[1] + a.x[2]; }
/// Sum of the products of all nine entries.
PALPATE_TARGET inline F8 dot(const Symmetric& a, const Symmetric& b) {
  const F8 mixed = mad(a.x[3], b.x[3], mad(a.x[4], b.x[4], a.x[5] * b.x[5]));
  return mad(a.x[0], b.x[0], mad(a.x[1], b.x[1], mad(a.x[2], b.x[2], mixed + mixed)));
}
PALPATE_TARGET inline Symmetric cofactors(const Symmetric& a) {
  const F8* const e = a.x;
  return {{minus_product(e[1] * e[2], e[3], e[3]), minus_product(e[0] * e[2], e[4], e[4]),
           minus_product(e[0] * e[1], e[5], e[5]), minus_product(e[4] * e[5], e[0], e[3]),
           minus_product(e[3] * e[5], e[1], e[4]), minus_product(e[3] * e[4], e[2], e[5])}};
}

/// J^(-2/3) - 1 from J - 1, without cancellation: Newton's steps for (1 + d)^3 J = 1 from a rational start. Below
/// J = .2, that of .2.
PALPATE_TARGET inline F8 isochoric_scale(const F8& volume_change) {
  const F8 one = F8::all(1.0F), three = F8::all(3.0F), third = F8::all(1.0F / 3.0F);
  const F8 x = max(volume_change, F8::all(-0.8F)), J = one + x;
  F8 d = F8::all(-1.0F / 3.0F) * x * reciprocal(mad(F8::all(2.0F / 3.0F), x, one));
  for (int k = 0; k < 2; ++k) {
    const F8 residual = mad(J, d * mad(d, d + three, three), x);
    d = minus_product(d, residual * third, one + d);
  }
  return d * (F8::all(2.0F) + d);
}

/// Strain without its change of volume, as the Prony terms measure it: Z = s A (elements.hpp).
struct Isochoric {
  Symmetric A, cofactor;
  F8 scale;    // J^(-2/3)
  F8 w;        // trace of A
  F8 square;   // |A|^2, not zero
  F8 s;        // Z over A
  F8 stiffer;  // 1 + 2 c w

  PALPATE_TARGET Isochoric(const Strain& strain, const F8& yeoh) {
    const F8 one = F8::all(1.0F), half = F8::all(0.5F), more = isochoric_scale(strain.volume_change());
    scale = one + more;
    const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
    for (int k = 0; k < 6; ++k) {  // F^T F - I = H + H^T + H^T H
      const int i = row[k], j = column[k];
      const F8(&H)[3][3] = strain.H;
      const F8 e = mad(H[0][i], H[0][j], mad(H[1][i], H[1][j], mad(H[2][i], H[2][j], H[i][j] + H[j][i])));
      A.x[k] = k < 3 ? mad(scale, e, more) : scale * e;
    }
    cofactor = cofactors(A);
    const F8 det = mad(A.x[0], cofactor.x[0], mad(A.x[5], cofactor.x[5], A.x[4] * cofactor.x[4]));
    // det(I + A) = 1 gives w = |A|^2/2 - w^2/2 - det A, which is small of second order: its sum would cancel.
    const F8 sum = trace_of(A), rest = mad(half * sum, sum, det), all = dot(A, A);
    square = max(all, F8::all(1e-24F));
    w = max(half * all - rest, F8::all(0.0F));
    const F8 share = max(minus_product(half, rest, reciprocal(square)), F8::all(1e-3F));
    s = root(share * mad(yeoh, w, one));
    stiffer = mad(yeoh + yeoh, w, one);
  }

  /// Second Piola-Kirchhoff stress Y : dZ/dE of the stress Y that belongs to Z. The change of s with A and the
  /// projection that keeps the volume are in it; I + B is the inverse of I + A.
  PALPATE_TARGET Symmetric stress(const Symmetric& Y) const {
    const F8 third = F8::all(1.0F / 3.0F), one = F8::all(1.0F), two = F8::all(2.0F);
    const F8 turn = dot(Y, A) * reciprocal(two * s * square), back = two * turn * s * s;
    Symmetric X;
    for (int k = 0; k < 6; ++k) X.x[k] = minus_product(s * Y.x[k], back, A.x[k]);
    const F8 level = third * (trace_of(X) + dot(X, A)), grown = turn * stiffer;
    const F8 on_unit = mad(grown * third, w, level), on_B = mad(grown, mad(third, w, one), level);
    const F8 twice = two * scale;
    Symmetric out;
    for (int k = 0; k < 6; ++k) {
      const F8 B = k < 3 ? w - A.x[k] + cofactor.x[k] : cofactor.x[k] - A.x[k];
      const F8 all = minus_product(X.x[k], on_B, B);
      out.x[k] = twice * (k < 3 ? all - on_unit : all);
    }
    return out;
  }
};

/// Second Piola-Kirchhoff stress of the Prony terms over the shear modulus. It advances the memory and adds the energy
/// of the terms, over half the shear modulus, to `energy`.
PALPATE_TARGET inline Symmetric viscous_stress(const Strain& strain, const F8& yeoh, const Viscosity& viscosity,
                                               HistoryBlock* history, F8& energy) {
  const Isochoric now(strain, yeoh);
  Symmetric sum;
  for (F8& x : sum.x) x = F8::all(0.0F);
  for (int t = 0; t < viscosity.terms; ++t) {
    const F8 share = F8::all(viscosity.share[t]), recover = F8::all(viscosity.recover[t]);
    Symmetric over;
    for (int k = 0; k < 6; ++k) {
      const F8 q = F8::load(history[t].q[k]);
      over.x[k] = now.s * now.A.x[k] - q;
      sum.x[k] = mad(share, over.x[k], sum.x[k]);
      mad(recover, over.x[k], q).store(history[t].q[k]);
    }
    energy = mad(share, dot(over, over), energy);
  }
  return now.stress(sum);
}

/// First Piola-Kirchhoff stress times volume: mu V (1 + 2 c w) (F - cof F) + p V cof F + F S of the Prony terms.
/// scale: mu V (1 + 2 c w); pressure: p V; viscous: S V of the Prony terms, null without them.
PALPATE_TARGET inline void full_stress(const Strain& s, const F8& scale, const F8& pressure, const Symmetric* viscous,
                                       F8 P[3][3]) {
  const F8 volumetric = pressure - scale, all = mad(volumetric, s.trace, pressure);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P[i][j] = volumetric * (s.cofactor[i][j] - s.H[j][i]);
  for (int i = 0; i < 3; ++i) P[i][i] = P[i][i] + all;
  if (viscous == nullptr) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) P[i][j] = mad(scale, s.H[i][j], P[i][j]);
    return;
  }
  const F8* const v = viscous->x;
  const F8 S[6] = {v[0] + scale, v[1] + scale, v[2] + scale, v[3], v[4], v[5]};
  const int at[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P[i][j] =
          mad(s.H[i][0], S[at[0][j]], mad(s.H[i][1], S[at[1][j]], mad(s.H[i][2], S[at[2][j]], P[i][j] + v[at[i][j]])));
}

/// First Piola-Kirchhoff stress times volume of eight elements; their energy is added to `energy`. history: of their
/// Prony terms; null without viscosity.
PALPATE_TARGET inline void stress_of(const Strain& s, const MaterialBlock& material, const Viscosity& viscosity,
                                     HistoryBlock* history, F8& energy, F8 P[3][3]) {
  const F8 one = F8::all(1.0F), two = F8::all(2.0F), half = F8::all(0.5F), zero = F8::all(0.0F);
  const F8 shear = F8::load(material.shear), bulk = F8::load(material.bulk), c = F8::load(material.yeoh);
  const F8 change = s.volume_change();
  F8 square = zero;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) square = mad(s.H[i][j], s.H[i][j], square);
  const F8 w = square - two * (s.second + s.det), stretch = max(w, zero);
  const F8 stiffening = mad(two * c, stretch, one);
  const F8 below = min(change + F8::all(1.0F - kFolded), zero), barrier = F8::load(material.barrier) * below;
  const F8 pressure = mad(bulk, change, barrier), compressed = mad(barrier, below, bulk * change * change);
  energy = mad(half * shear, mad(c * stretch, stretch, w), mad(half, compressed, energy));
  if (history == nullptr) return full_stress(s, shear * stiffening, pressure, nullptr, P);
  F8 halves = zero;
  const F8 viscous_shear = F8::load(material.viscous);
  Symmetric viscous = viscous_stress(s, c, viscosity, history, halves);
  for (F8& x : viscous.x) x = x * viscous_shear;
  energy = mad(half * viscous_shear, halves, energy);
  full_stress(s, shear * stiffening, pressure, &viscous, P);
}

PALPATE_TARGET inline Strain strain_of(const ElementBlock& block, const CornerBlock* corners, const float* u) {
  Strain s;
  for (auto& row : s.H)
    for (F8& x : row) x = F8::all(0.0F);
  const Rows middle = load_rows(u, block.row);
  for (std::uint32_t k = block.first; k < block.last; ++k) {
    F8 d[3];
    differences(u, corners[k].row, middle, d);
    for (int j = 0; j < 3; ++j) {
      const F8 slope = F8::load(corners[k].slope[j]);
      for (int i = 0; i < 3; ++i) s.H[i][j] = mad(d[i], slope, s.H[i][j]);
    }
  }
  find_invariants(s);
  return s;
}

/// Takes the forces of eight elements from their corners, and adds their sums to the first ones. The corners follow one
/// after the other, because a node may occur more than once.
PALPATE_TARGET inline void add_element_forces(const F8 P[3][3], const ElementBlock& block, const CornerBlock* corners,
                                              float* force) {
  F8 sum[3] = {F8::all(0.0F), F8::all(0.0F), F8::all(0.0F)};
  for (std::uint32_t k = block.first; k < block.last; ++k) {
    const F8 g[3] = {F8::load(corners[k].slope[0]), F8::load(corners[k].slope[1]), F8::load(corners[k].slope[2])};
    F8 f[3];
    for (int i = 0; i < 3; ++i) {
      f[i] = minus_product(minus_product(F8::all(0.0F) - P[i][0] * g[0], P[i][1], g[1]), P[i][2], g[2]);
      sum[i] = sum[i] - f[i];
    }
    add_to_rows(f, corners[k].row, force);
  }
  add_to_rows(sum, block.row, force);
}

PALPATE_TARGET inline void forces_in(const ElementList& list, NodeArrays& nodes) {
  F8 energy = F8::all(0.0F), least = F8::all(1.0F);
  for (std::size_t b = 0; b < list.count; ++b) {
    const ElementBlock& block = list.blocks[b];
    const Strain s = strain_of(block, list.corners, nodes.u);
    least = min(least, F8::all(1.0F) + s.volume_change());
    F8 P[3][3];
    HistoryBlock* const history = list.viscosity.terms > 0 && list.history != nullptr
                                      ? list.history + b * static_cast<std::size_t>(list.viscosity.terms)
                                      : nullptr;
    stress_of(s, block.material, list.viscosity, history, energy, P);
    add_element_forces(P, block, list.corners, nodes.force);
  }
  float lanes[kWide];
  energy.store(lanes);
  for (const float x : lanes) nodes.energy += static_cast<double>(x);
  least.store(lanes);
  for (const float x : lanes)
    nodes.least_volume = static_cast<double>(x) < nodes.least_volume ? static_cast<double>(x) : nodes.least_volume;
}
