// Forces of linear tetrahedra, eight at a time, in single precision.
//
// With the displacement gradient H = F - I, all measures of strain are polynomials of H that vanish at rest. Single
// precision therefore loses nothing to cancellation:
//
//   J - 1 = tr H + tr cof H + det H          w = I1 - 3 - 2 (J - 1) = |H|^2 - 2 tr cof H - 2 det H
//
// The energy per volume is psi = mu/2 (w + c max(w, 0)^2) + k/2 (J - 1)^2, k = lambda + mu: a stable Neo-Hookean solid
// (after Smith, de Goes and Kim 2018, without their logarithm) with a stiffening term after Yeoh (1993); w = I1 - 3
// where the volume is kept. mu and lambda are the constants of Lame at rest. psi is finite for any F, also for inverted
// tetrahedra. Viscosity is quasi-linear: each Prony term adds g (S - q) with q' = (S - q) / tau, where S is the second
// Piola-Kirchhoff stress of the terms with mu (Taylor and others 2009).
//
// The averaged pressures let a tetrahedron invert beside others that grow. A barrier 4 k/2 min(J - .3, 0)^2 of its own
// prevents this; it is zero at the strains of palpation.
//
// The volume term uses the mean of the pressures of the four corners, which are averages over the tetrahedra around a
// node (Bonet and Burton 1998), and a share of the tetrahedron's own: linear tetrahedra would lock near nu = .5.
//
// This header does not use Eigen, because it is included by files that are compiled for wider instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::tissue {

inline constexpr int kWide = 8;      ///< tetrahedra in a block
inline constexpr int kMaxProny = 4;  ///< largest number of Prony terms

/// Eight tetrahedra. Unused ones have zero stiffness.
struct alignas(32) ElementBlock {
  std::uint32_t row[4][kWide];  ///< index of the first of the four numbers of each corner: 4 times the node
  float slope[9][kWide];        ///< gradients of the shape functions of corners 1 to 3, at rest [1/m]
  float shear[kWide];           ///< shear modulus times volume [N m]
  float bulk[kWide];            ///< k of the tetrahedron itself times volume, of its share of the pressure [N m]
  float volume[kWide];          ///< volume at rest [m^3]
  float yeoh[kWide];            ///< coefficient c [-]
};

/// Memory of one Prony term of eight tetrahedra: the relaxed stress q over the shear modulus, xx yy zz yz xz xy [-].
struct alignas(32) HistoryBlock {
  float q[6][kWide];
};

/// Viscosity of a step.
struct Viscosity {
  int terms = 0;               ///< number of Prony terms
  float share[kMaxProny]{};    ///< g of each term [-]
  float recover[kMaxProny]{};  ///< 1 - exp(-step / tau) [-]
};

/// Everything that the kernels read and write.
struct ElementArrays {
  const ElementBlock* blocks = nullptr;
  HistoryBlock* history = nullptr;  ///< `terms` for each block; null without viscosity
  std::size_t count = 0;            ///< number of blocks
  const float* u = nullptr;         ///< four numbers a node: its displacement [m], and its pressure without the
                                    ///< tetrahedra's own share [Pa]
  float* dilatation = nullptr;      ///< result of the first pass: (J - 1) volume / 4, of all first lanes, all second
                                    ///< ones, ... [m^3]
  float* force = nullptr;           ///< forces on the nodes, four numbers a node; the kernel adds to them [N]
  Viscosity viscosity;
  double shear_energy = 0.0;  ///< result: energy without the nodes' pressures, Prony terms included [J]
  double least_volume = 0.0;  ///< result: smallest J [-]
};

/// The two passes over the tetrahedra.
struct Kernel {
  /// Sets the dilatation of all tetrahedra.
  void (*find_dilatation)(ElementArrays&) noexcept;
  /// Adds the forces of all tetrahedra, advances the viscous memory by a step, and sets the results.
  void (*add_forces)(ElementArrays&) noexcept;
};
Kernel avx2_kernel() noexcept;
Kernel portable_kernel() noexcept;
/// True if this processor supports AVX2 and FMA.
bool has_avx2() noexcept;

}  // namespace palpate::tissue
