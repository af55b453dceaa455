// The contact of the tool with an object as estimated, and as it would be with perturbed estimates.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "palpate/contact/tool.hpp"
#include "palpate/network/estimator.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::network {

/// Copies of one object with the place and stiffness of the estimator's guesses. Each has a contact of its own with the
/// tool, which remembers where it has begun to stick. Their friction is constant as long as the tool touches them,
/// since a contact that has slipped with the wrong friction sticks in the wrong place: two copies have less and more of
/// it, and forces in between are interpolated.
class Copies {
 public:
  /// object: as the scene has it; radius: of the tool's sphere [m].
  Copies(const scene::Object& object, double radius);
  /// Moves the object without a contact being lost: friction keeps its anchors in W.
  void place(const Vec3& p_WO) noexcept { X_WO_.p = p_WO; }
  /// The object is another one: all contacts begin anew.
  void reset() noexcept {
    for (auto& copy : copies_) copy->tool.reset();
  }
  /// Contacts of the tool at p [m] at the time t of the scene [s]. A copy that was left out for kApart begins anew.
  const Prediction& step(const Estimator& estimator, const Vec3& p, double t) noexcept;
  /// Contact with the object as estimated, valid while the prediction is touching.
  [[nodiscard]] const Contact& contact() const noexcept { return contact_; }

 private:
  static constexpr double kApart = 0.01;  ///< [s]
  struct Copy {
    Copy(const scene::Object& object, double radius);
    scene::Snapshot scene;
    contact::Tool tool;
  };
  const Vec3& touch(std::size_t copy, const Guess& guess, double mu) noexcept;
  void interpolate(double mu) noexcept;

  Pose X_WO_;
  std::array<std::unique_ptr<Copy>, 3 + 2 * kAcross> copies_;
  std::array<Vec3, 3 + 2 * kAcross> F_;  ///< forces of the copies [N]
  double mu_ = 0.0, wide_ = 0.0;         ///< friction of the copies, and its difference to those with more or less
  Vec3 p_ = Vec3::Zero();
  Prediction prediction_;
  Contact contact_;
  double t_ = 0.0;
  std::uint64_t ticks_ = 0;
  int touching_ = 0;  ///< copies that touch the tool
};

}  // namespace palpate::network
