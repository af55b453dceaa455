// Forces of linear tetrahedra and of the patches around nodes, eight at a time, in single precision.
//
// With the displacement gradient H = F - I, all measures of strain are polynomials of H that vanish at rest. Single
// precision therefore loses nothing to cancellation:
//
//   J - 1 = tr H + tr cof H + det H          w = I1 - 3 - 2 (J - 1) = |H|^2 - 2 tr cof H - 2 det H
//
// The energy per volume is psi = mu/2 (w + c max(w, 0)^2) + k/2 (J - 1)^2, k = bulk + mu/3: a stable Neo-Hookean solid
// (after Smith, de Goes and Kim 2018, without their logarithm) with a stiffening term after Yeoh (1993); w = I1 - 3
// where the volume is kept. mu and bulk are the moduli at rest. psi is finite for any F, also for inverted tetrahedra.
//
// Linear tetrahedra alone are too stiff in bending, and lock near nu = .5. Most of the energy is therefore that of
// patches: the patch of a node has a quarter of the volume of each tetrahedron around it, and the mean of their F
// (Dohrmann and others 2000). A patch alone is too soft and has modes without energy, so that the tetrahedra keep the
// rest (Puso and Solberg 2006); the shares are in body_build.cpp. Averages of F are linear in the displacements: a
// patch is an element whose nodes are its neighbours.
//
// Viscosity is that of the patches alone, and keeps the volume elastic. Each Prony term has a spring of the energy
// g mu/2 |Z - q|^2 with q' = (Z - q) / tau, where Z(F) measures the strain without the change of volume: with A =
// J^(-2/3) F^T F - I and its trace w^,
//
//   Z = s A,   s^2 = w^ (1 + c w^) / |A|^2,   hence mu/2 |Z|^2 = mu/2 (w^ + c w^^2).
//
// A strain that is held therefore relaxes by the series at any size, and the term only dissipates, because its stress
// is the derivative of its energy. The stress is exact for strains that change linearly within a step.
//
// A barrier 4 k/2 min(J - .3, 0)^2 keeps tetrahedra from inverting inside patches; it is zero at the strains of
// palpation.
//
// This header does not use Eigen, because it is included by files that are compiled for wider instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::tissue {

inline constexpr int kWide = 8;      ///< tetrahedra in a block
inline constexpr int kMaxProny = 4;  ///< largest number of Prony terms

/// Material of eight tetrahedra or patches, their share of the energy; zero for those that are unused.
struct alignas(32) MaterialBlock {
  float shear[kWide];    ///< shear modulus times volume [N m]
  float bulk[kWide];     ///< k times volume [N m]
  float barrier[kWide];  ///< modulus of the barrier times volume [N m]
  float viscous[kWide];  ///< shear modulus that the Prony terms multiply, times volume [N m]
  float yeoh[kWide];     ///< coefficient c [-]
};

/// Eight tetrahedra with their first corners, or eight patches with the nodes in their middle.
struct alignas(32) ElementBlock {
  std::uint32_t row[kWide];  ///< index of the first of the four numbers of the node: 4 times the node
  std::uint32_t first;       ///< the other corners are those from first to last
  std::uint32_t last;
  MaterialBlock material;
};

/// Another corner of the eight elements of a block.
struct alignas(32) CornerBlock {
  std::uint32_t row[kWide];  ///< 4 times the node
  float slope[3][kWide];     ///< gradient of its shape function, of a patch the mean; zero for fewer corners [1/m]
};

/// Memory of one Prony term of eight patches: the strain q of its damper, xx yy zz yz xz xy [-].
struct alignas(32) HistoryBlock {
  float q[6][kWide];
};

/// Viscosity of a step.
struct Viscosity {
  int terms = 0;               ///< number of Prony terms
  float share[kMaxProny]{};    ///< g of each term, times the mean of exp(-t / tau) over the step [-]
  float recover[kMaxProny]{};  ///< 1 - exp(-step / tau) [-]
};

/// Elements of one kind, and what their forces are computed from.
struct ElementList {
  const ElementBlock* blocks = nullptr;
  std::size_t count = 0;  ///< number of blocks
  const CornerBlock* corners = nullptr;
  HistoryBlock* history = nullptr;  ///< `terms` for each block; null without viscosity
  Viscosity viscosity;
};

/// The nodes that the kernel reads and writes, and its results.
struct NodeArrays {
  const float* u = nullptr;   ///< displacements, four numbers a node [m]
  float* force = nullptr;     ///< forces, four numbers a node; the kernel adds to them [N]
  double energy = 0.0;        ///< the kernel adds the energy of the elements, that of the Prony terms included [J]
  double least_volume = 1.0;  ///< the kernel lowers it to the smallest J [-]
};

/// Adds the forces and the energy of the elements, and advances their viscous memory by a step.
using Kernel = void (*)(const ElementList&, NodeArrays&) noexcept;
Kernel avx2_kernel() noexcept;
Kernel portable_kernel() noexcept;
/// True if this processor supports AVX2 and FMA.
bool has_avx2() noexcept;

}  // namespace palpate::tissue
