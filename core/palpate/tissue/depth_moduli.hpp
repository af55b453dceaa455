// What a contact feels of a material that changes below the surface.
//
// Under a load, the displacement u_z(z) of a half-space decreases with the depth z (Boussinesq). The layer between z
// and z + dz yields the share -du_z / u_z(0) of it. With a modulus E*(z), the half-space therefore yields as one of the
// modulus 1 / integral of shares / E*(z). This is exact for a constant modulus; for lumps it is judged by finite
// elements (palpate_lab.verify.tissue). The shares are those under the middle of Hertz's pressure for a sphere, and of
// a Gaussian for the spread load of the body.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/scene/mesh.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/tissue/body.hpp"

namespace palpate::tissue {

/// Of the force of a Yeoh solid, F = F of a Neo-Hookean one times 1 + kYeoh c d / R up to d = .75 R, by finite elements
/// (palpate_lab.verify.tissue).
inline constexpr double kYeoh = 0.18;

/// Moduli E* and stiffening of each vertex of a surface, as contacts of several sizes and the spread load feel them.
class DepthModuli {
 public:
  DepthModuli() = default;
  /// mesh: the surface at rest; edge: mean length of the edges [m]; width:
  /// standard deviation of the spread load [m].
  DepthModuli(const scene::Mesh& mesh, const BodyData& data, double edge, double width);

  /// Material at a point of the surface.
  struct Felt {
    double pressed = 0.0;  ///< E* for a sphere at small depth [Pa]
    double growth = 0.0;   ///< relative change of the secant modulus at the depth of a radius, because the contact
                           ///< widens and because the material stiffens
    double spread = 0.0;   ///< E* for the spread load [Pa]
  };
  /// vertex, weight: vertices of the surface under the contact, with weights of the sum 1; radius: of the sphere [m].
  [[nodiscard]] Felt at(std::span<const std::int32_t> vertex, const double* weight, double radius) const noexcept;

 private:
  static constexpr std::size_t kContacts = 4;  ///< radii of contact, each twice the one before
  struct Values {
    std::array<double, kContacts> pressed{};
    double spread = 0.0;
    double yeoh = 0.0;  ///< coefficient c [-]
    [[nodiscard]] bool operator==(const Values&) const = default;
  };

  std::vector<Values> values_;  ///< of each vertex
  double width_ = 1.0;
  bool constant_ = true;  ///< all values_ are equal
};

}  // namespace palpate::tissue
