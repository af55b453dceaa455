// The surface of a soft body, as contact methods touch it: rest positions plus displacements that are spread over a few
// elements (spreading.hpp), with the near field of a contact (local_law.hpp) above it.
//
// A small body steps in every tick. A large one steps beside the cycle, by a period of several ticks at once: the cycle
// hands over the contacts and their velocities at the beginning of a period, and takes the shape at its end. Between
// two shapes the surface stands still, and the local law follows the tool alone. Without another thread the body steps
// at the beginning of the period, and its shape is taken at the end all the same.
//
// Such an exchange can give energy to the tool. The surface therefore observes the energy that the tools have put in,
// and compares it with what body and contacts store. While the tools move out, the force is scaled by the ratio of both
// if it is below 1: along the law dW = -(W / U) F dx with dU = -F dx, the ratio W / U stays constant, so that W reaches
// zero together with U, and not before (an observer and controller of passivity, after Hannaford and Ryu 2002).
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/scene/deformable.hpp"
#include "palpate/tissue/pressed_body.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::tissue {

/// A soft body with its surface.
class SoftSurface final : public scene::Surface, public scene::Deformable {
 public:
  static constexpr int kTools = 8;           ///< tools with a viscous memory
  static constexpr int kSpheresOfTool = 16;  ///< spheres of a tool with a viscous memory

  /// width: standard deviation by which the mesh spreads a force [m]; 0: .7 of the mean length of the surface's edges,
  /// which keeps the contact independent of the place of its nodes. period: of the steps
  /// beside the cycle [s]; 0: the body steps in every tick. continues: id of another surface of the same body; 0: a new
  /// one. Throws std::invalid_argument if the body has no surface, or if the period is negative or above 50 ms.
  explicit SoftSurface(const Body& body, double width = 0.0, double period = 0.0, std::uint64_t continues = 0);

  [[nodiscard]] scene::Nearest nearest(const Vec3& p) const noexcept override { return mesh_->nearest(p); }
  [[nodiscard]] scene::Nearest nearest_or_far(const Vec3& p, double exact_within) const noexcept override {
    return mesh_->nearest_or_far(p, exact_within);
  }
  [[nodiscard]] const scene::Mesh* mesh() const noexcept override { return mesh_.get(); }
  [[nodiscard]] Deformable* deformable() const noexcept override { return const_cast<SoftSurface*>(this); }

  [[nodiscard]] std::shared_ptr<Surface> at_rest() const override;
  /// A copy at rest that steps in every tick.
  [[nodiscard]] std::shared_ptr<SoftSurface> in_cycle() const;
  /// The newest shape that is touched.
  [[nodiscard]] const Shape& shape() const noexcept { return shape_; }
  [[nodiscard]] scene::Response respond(const scene::SpherePlace& at) const noexcept override;
  [[nodiscard]] Vec3 velocity(const Vec3& p) const noexcept override;
  void advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept override;
  /// Instead of advance(), for a view of a body that is stepped elsewhere (shared_surface.hpp): advances the viscous
  /// memory under the contacts by a tick, and then takes over the shape of that body.
  void remember(std::span<const scene::SurfaceLoad> loads, double dt) noexcept;
  void follow(const Shape& shape, double dt) noexcept;
  [[nodiscard]] scene::DeformableState state() const noexcept override;
  [[nodiscard]] std::span<const double> published() noexcept override { return published_.read(); }
  [[nodiscard]] double period() const noexcept override { return period_; }
  void set_beside(bool beside) noexcept override { beside_ = beside; }
  /// True: a loop that runs more than twice as fast as real time waits for its thread beside, so that its results
  /// depend on its inputs alone. For loops that are not in real time; copies at rest inherit it.
  void set_patient(bool patient) noexcept { patient_ = patient; }
  bool work() noexcept override;

  [[nodiscard]] const Body& body() const noexcept { return pressed_.body(); }
  /// For tests of the guard, while no other thread steps the body.
  [[nodiscard]] PressedBody& pressed() noexcept { return pressed_; }
  /// Mean length of the edges of the surface at rest [m].
  [[nodiscard]] double edge() const noexcept { return tables_->edge; }
  [[nodiscard]] double width() const noexcept { return tables_->spreading.width(); }

 private:
  static constexpr int kSpheres = kTools * kSpheresOfTool;
  using Memory = std::array<double, kMaxProny>;
  /// A sphere that meets the surface.
  struct Met {
    Patch patch;
    Meeting at;
    LocalLaw law{1.0, 1.0, 0.0};
    std::array<double, kPatchVertices> share{};  ///< of the vertices of the patch
    Vec3 centre = Vec3::Zero();                  ///< of the sphere [m]
    double radius = 0.0;
    bool found = false;
  };
  /// Motion of a sphere that touches.
  struct Motion {
    Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero(), force = Vec3::Zero();  ///< of the sphere; on it [N]
    Vec3 axis = Vec3::Zero();                                                   ///< of its patch
    double felt = 0.0;            ///< elastic force by the shape of this tick [N]
    double bridge = 1.0;          ///< share of the force that leads over from the shape before
    Vec3 turn = Vec3::Zero();     ///< of its direction, likewise; zero in the end
    Vec3 normal = Vec3::Zero();   ///< direction of the force by the shape of this tick
    Vec3 carried = Vec3::Zero();  ///< motion of the surface that holds it, from the shape before to that of this tick
    bool carries = false;         ///< the shape is new in this tick, and the sphere has pressed the body to it
    std::int32_t heaviest = -1;   ///< triangle of its patch with the largest share
    int bridging = 0;             ///< ticks until it is 1
    bool known = false;
  };

  SoftSurface(const SoftSurface& from, std::uint64_t id, double period);
  const Met& meet(const scene::SpherePlace& place) const noexcept;
  [[nodiscard]] LocalLaw law_of(const Met& met) const noexcept;
  [[nodiscard]] LocalLaw::Value value_of(const Met& met, int sphere) const noexcept;
  [[nodiscard]] double viscous_force(int sphere, double elastic) const noexcept;
  void take(std::span<const scene::SurfaceLoad> loads) noexcept;
  void observe(const scene::SurfaceLoad& load, const Met& met, Touch& touch) noexcept;
  void withhold(double dt) noexcept;
  void relax(double dt) noexcept;
  bool exchange(double dt) noexcept;
  void carry() noexcept;
  void wait_for_thread() noexcept;
  void bridge(std::span<const scene::SurfaceLoad> loads) noexcept;
  void show() noexcept;
  void ramp(double dt) noexcept;
  void publish(double dt) noexcept;

  std::shared_ptr<const SoftTables> tables_;
  double period_ = 0.0, instantaneous_ = 1.0;  // instantaneous_: 1 + sum of the Prony shares
  bool patient_ = false;
  PressedBody pressed_;  // used by the thread beside, if there is one
  std::shared_ptr<scene::Mesh> mesh_;
  std::array<Memory, kSpheres> memory_{};
  std::array<Motion, kSpheres> motion_{};
  std::array<double, kMaxTouches> elastic_{};  // forces of the touches without viscosity [N]

  Press press_;         // contacts of this tick; number: of the last press that was handed over
  Shape shape_, made_;  // as touched; made_: of the thread that steps the body
  Mailbox<Press> presses_;
  Mailbox<Shape> shapes_;
  std::atomic<bool> beside_{false};
  std::atomic<bool> working_{false};
  std::chrono::steady_clock::time_point handed_over_;
  bool waiting_ = false, late_ = false, frozen_ = false;  // waiting_: for the shape of the last press
  double overdue_ = 0.0;                                  // time since this shape was due [s]
  double share_ = 1.0;                                    // of the force that acts, after a divergence
  double put_in_ = 0.0;                                   // energy that the tools have put in [J]
  double given_ = 0.0;                                    // energy that the tools get in this tick [J]
  double stored_ = 0.0;                                   // near the contacts of this tick [J]
  double passive_ = 1.0;                                  // share of the force that gives no energy

  static constexpr std::size_t kMet = 16;
  mutable std::array<Met, kMet> met_;  // spheres that met the surface as it is
  mutable std::size_t next_met_ = 0;
  mutable std::vector<std::uint32_t> seen_;  // last round of each triangle
  mutable std::uint32_t round_ = 0;
  mutable std::array<Vec3, kPatchVertices> x_, pull_;

  Mailbox<std::vector<double>> published_;
  double unpublished_ = 0.0;  // time since the vertices were published [s]
};

}  // namespace palpate::tissue
