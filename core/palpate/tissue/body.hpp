// A soft body: an explicit total-Lagrangian finite-element model of linear tetrahedra (Miller and others 2007), small
// enough to run inside the haptic cycle. elements.hpp states the strain energy.
//
// All positions are in the object's frame O. Inertial forces of a moving frame O are neglected, and there is no weight:
// the given shape is at rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/tissue/elements.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::tissue {

/// One term of the Prony series mu(t) = mu (1 + sum g exp(-t / tau)).
struct PronyTerm {
  double g = 0.0;    ///< share of the shear modulus at rest [-]
  double tau = 1.0;  ///< relaxation time [s]
};

inline constexpr double kLargestShare = 100.0;                   ///< of the sum of g [-]
inline constexpr double kShortestTau = 1e-5, kLongestTau = 1e3;  ///< [s]

/// What a body is made from. Vectors have one entry per node or tetrahedron.
struct BodyData {
  std::vector<double> nodes;          ///< 3n positions at rest [m]
  std::vector<std::int32_t> tets;     ///< 4m indices of nodes
  std::vector<std::int32_t> surface;  ///< 3k indices of nodes, outward winding
  std::vector<double> mu, bulk;       ///< (m) shear modulus after full relaxation, bulk modulus [Pa]
  std::vector<double> density, yeoh;  ///< (m) [kg/m^3], [-]
  std::vector<PronyTerm> prony;       ///< at most kMaxProny terms
  std::vector<std::uint8_t> fixed;    ///< (n) nodes that do not move; empty: none
  std::vector<double> spring;         ///< (n) stiffness of the springs to the rest positions; empty: none [N/m]
  double step = 0.0;                  ///< time step; 0: chosen from `tick` and `mass_limit` [s]
  double tick = 1e-3;                 ///< period of the loop that steps the body [s]
  double damping = 5.0;               ///< damping force per mass and velocity [1/s]
  double mass_limit = 0.05;           ///< added mass up to which a longer step is chosen, share of the mass [-]
  bool portable = false;              ///< true: the portable kernels, for tests
};

/// Energies of a body.
struct BodyEnergy {
  double potential = 0.0;  ///< stored by strain, Prony terms and springs [J]
  double kinetic = 0.0;    ///< of the nodes, added mass included [J]
};

/// A soft body. After the construction nothing allocates or throws.
class Body {
 public:
  /// Throws std::invalid_argument naming an invalid value, with its index.
  explicit Body(BodyData data);

  /// Advances by a time step, or by its half if parts = 2: strain, springs, damping and loads.
  void step(int parts = 1) noexcept;
  /// Returns to rest.
  void reset() noexcept;
  /// Adds a force on a node for the following steps until clear_loads(). force: in O [N].
  void add_load(std::int32_t node, const Vec3& force) noexcept;
  void clear_loads() noexcept;

  [[nodiscard]] const BodyData& data() const noexcept { return data_; }
  [[nodiscard]] std::size_t node_count() const noexcept { return data_.nodes.size() / 3; }
  [[nodiscard]] std::size_t tet_count() const noexcept { return data_.tets.size() / 4; }
  /// Time step [s], and steps in a period of the loop.
  [[nodiscard]] double time_step() const noexcept { return data_.step; }
  [[nodiscard]] int steps_per_tick() const noexcept { return steps_; }
  /// Longest stable time step without added mass: a bound from the stiffest tetrahedron at rest [s].
  [[nodiscard]] double stable_step() const noexcept { return stable_step_; }
  /// Mass added for the time step, as a share of the mass [-].
  [[nodiscard]] double added_mass() const noexcept { return added_mass_; }
  [[nodiscard]] Vec3 displacement(std::int32_t node) const noexcept {
    return Vec3(&u_[3 * static_cast<std::size_t>(node)]);
  }
  [[nodiscard]] Vec3 velocity(std::int32_t node) const noexcept {
    return Vec3(&v_[3 * static_cast<std::size_t>(node)]);
  }
  /// Displacements [m] and velocities [m/s] of all nodes, 3n.
  [[nodiscard]] std::span<const double> displacements() const noexcept { return u_; }
  [[nodiscard]] std::span<const double> velocities() const noexcept { return v_; }
  /// Four numbers in single precision, aligned for vector instructions.
  struct alignas(16) Four {
    float x[4];
  };
  /// Displacements [m] and velocities [m/s] of all nodes in single precision; the fourth number has no meaning here.
  [[nodiscard]] std::span<const Four> displacements32() const noexcept { return u32_; }
  [[nodiscard]] std::span<const Four> velocities32() const noexcept { return v32_; }
  /// Masses of the nodes, added mass included (n) [kg].
  [[nodiscard]] std::span<const double> masses() const noexcept { return mass_; }
  /// Sets the displacements and velocities, 3n each; for tests and for a return to an earlier state.
  void set_state(std::span<const double> displacements, std::span<const double> velocities) noexcept;
  /// Internal forces at the present displacements, 3n [N]; for tests. It does not advance the viscous memory.
  void internal_forces(std::span<double> out) noexcept;
  /// Energies. The potential is that at the beginning of the last step.
  [[nodiscard]] BodyEnergy energy() const noexcept;
  /// Smallest J = det F of a tetrahedron at the beginning of the last step; zero or less: inverted [-].
  [[nodiscard]] double least_volume() const noexcept { return nodes_.least_volume; }
  /// Largest displacement of a node in the last step [m]; NaN if a number is not finite.
  [[nodiscard]] double fastest() const noexcept { return fastest_; }
  /// Layers of nodes below the free surface near each node, at most 4 (n): 0 where the body is one tetrahedron thick,
  /// 1 for two or three, 2 for four or five, and so on.
  [[nodiscard]] std::span<const std::int32_t> layers() const noexcept { return layers_; }
  /// Shortest height of a tetrahedron at rest [m].
  [[nodiscard]] double least_height() const noexcept { return least_height_; }

 private:
  void check() const;
  void measure();
  void find_layers();
  void share_moduli();
  void make_tets();
  void make_patches();
  void choose_step(const std::vector<double>& frequency2);
  [[nodiscard]] std::vector<double> frequencies2() const;
  void find_forces(const Viscosity& viscosity) noexcept;
  void integrate(double dt) noexcept;

  BodyData data_;
  std::vector<ElementBlock> tets_, patches_;
  std::vector<CornerBlock> corners_;           ///< of both
  std::vector<HistoryBlock> history_;          ///< of the patches
  std::vector<Four> u32_, force_;              ///< as the kernels want them; one more than nodes
  std::vector<Four> v32_;                      ///< velocities of the nodes; one more than nodes
  std::vector<double> u_, v_;                  ///< (3n)
  std::vector<double> mass_, inverse_mass_;    ///< (n)
  std::vector<std::int32_t> layers_;           ///< (n)
  std::vector<double> volume_;                 ///< (m) [m^3]
  std::vector<double> patch_volume_;           ///< (n) [m^3]
  std::vector<double> patch_mu_, patch_bulk_;  ///< (n) moduli of the patches at rest [Pa]
  std::vector<double> mean_mu_, mean_yeoh_;    ///< (n) means of the tetrahedra around a node [Pa], [-]
  std::vector<double> own_mu_, own_bulk_;      ///< (m) what the tetrahedra keep [Pa]
  std::vector<double> load_;                   ///< (3n) [N]
  std::vector<std::int32_t> loaded_;           ///< nodes with a load
  std::size_t loaded_count_ = 0;
  NodeArrays nodes_;
  Viscosity viscosity_[2];  ///< of a whole and of half a step
  Kernel kernel_;
  double stable_step_ = 0.0, added_mass_ = 0.0, fastest_ = 0.0, least_height_ = 0.0;
  int steps_ = 1;
};

}  // namespace palpate::tissue
