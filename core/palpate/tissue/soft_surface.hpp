// The surface of a soft body, as contact methods touch it: rest positions plus displacements that are spread over a few
// elements (spreading.hpp), with the near field of a contact (local_law.hpp) above it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/scene/deformable.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/tissue/body.hpp"
#include "palpate/tissue/local_law.hpp"
#include "palpate/tissue/spreading.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::tissue {

/// A soft body with its surface.
class SoftSurface final : public scene::Surface, public scene::Deformable {
 public:
  static constexpr int kTools = 8;           ///< tools with a viscous memory
  static constexpr int kSpheresOfTool = 16;  ///< spheres of a tool with a viscous memory
  static constexpr int kTouches = 64;        ///< contacts that act on the body at the same time

  /// width: standard deviation of the spread contact force [m]; 0: .7 of the mean length of the surface's edges. It
  /// should be at least .45 of the largest sphere's radius, or else deep contacts are too stiff. continues: id of
  /// another surface of the same body; 0: a new one. Throws std::invalid_argument if the body has no surface.
  explicit SoftSurface(BodyData data, double width = 0.0, std::uint64_t continues = 0);

  [[nodiscard]] scene::Nearest nearest(const Vec3& p) const noexcept override { return mesh_->nearest(p); }
  [[nodiscard]] scene::Nearest nearest_or_far(const Vec3& p, double exact_within) const noexcept override {
    return mesh_->nearest_or_far(p, exact_within);
  }
  [[nodiscard]] const scene::Mesh* mesh() const noexcept override { return mesh_.get(); }
  [[nodiscard]] Deformable* deformable() const noexcept override { return const_cast<SoftSurface*>(this); }

  [[nodiscard]] std::shared_ptr<Surface> at_rest() const override;
  [[nodiscard]] scene::Response respond(const scene::SpherePlace& at) const noexcept override;
  void advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept override;
  /// Instead of advance(), for a view of a body that is stepped elsewhere (shared_surface.hpp): advances the viscous
  /// memory under the contacts by a tick, and then takes over displacements [m] and velocities [m/s], 3 per node.
  void remember(std::span<const scene::SurfaceLoad> loads, double dt) noexcept;
  void follow(std::span<const double> displacements, std::span<const double> velocities, double dt) noexcept;
  [[nodiscard]] scene::DeformableState state() const noexcept override;
  [[nodiscard]] std::span<const double> published() noexcept override { return published_.read(); }

  [[nodiscard]] const Body& body() const noexcept { return body_; }
  /// Mean length of the edges of the surface at rest [m].
  [[nodiscard]] double edge() const noexcept { return edge_; }
  [[nodiscard]] double width() const noexcept { return tables_->spreading.width(); }

 private:
  static constexpr int kSpheres = kTools * kSpheresOfTool;
  using Memory = std::array<double, kMaxProny>;

  /// What all copies share.
  struct Tables {
    Spreading spreading;
    std::vector<std::int32_t> node;           ///< node of the body for each vertex of the mesh
    std::shared_ptr<const scene::Mesh> rest;  ///< the surface at rest
    std::vector<double> plane_modulus;        ///< E* of the tetrahedron behind each triangle [Pa]
  };
  /// A load at its place on the mesh.
  struct Touch {
    scene::SurfacePoint at;
    LocalLaw law{1.0, 1.0, 0.0};
    int sphere = 0;
    double depth = 0.0, viscous = 0.0, secant = 0.0;
    Vec3 normal = Vec3::Zero(), force = Vec3::Zero(), start = Vec3::Zero();
  };

  SoftSurface(const SoftSurface& from, std::uint64_t id);
  /// Where a sphere touches, and its depth below the touched surface.
  struct Site {
    scene::SurfacePoint at;
    double depth = 0.0;
  };
  [[nodiscard]] Site locate(const scene::SpherePlace& place) const noexcept;
  [[nodiscard]] LocalLaw law_at(const scene::SurfacePoint& at, double radius) const noexcept;
  [[nodiscard]] Vec3 spread(const scene::SurfacePoint& at, std::span<const double> nodal) const noexcept;
  [[nodiscard]] double viscous_force(int sphere, double elastic) const noexcept;
  void take(std::span<const scene::SurfaceLoad> loads) noexcept;
  void push() noexcept;
  void relax(double dt) noexcept;
  void guard(double dt) noexcept;
  void move_surface() noexcept;
  void publish(double dt) noexcept;

  Body body_;
  std::shared_ptr<const Tables> tables_;
  std::shared_ptr<scene::Mesh> mesh_;
  double edge_ = 0.0, instantaneous_ = 1.0;  // instantaneous_: 1 + sum of the Prony shares
  std::array<Memory, kSpheres> memory_{};
  std::array<Touch, kTouches> touch_;
  int touches_ = 0;
  std::vector<double> vertices_;  // of the mesh, 3 per vertex [m]
  Mailbox<std::vector<double>> published_;
  double unpublished_ = 0.0;            // time since vertices_ were published [s]
  std::vector<double> safe_u_, still_;  // displacements before the tick; zero velocities
  bool hurried_ = false;
  double frozen_ = 0.0;  // time left of standing still and of the ramp [s]
};

}  // namespace palpate::tissue
