// The operator's end: the hand feels the local model, or the remote force as far as the energies of both ports allow.
#pragma once

#include <vector>

#include "palpate/contact/tool.hpp"
#include "palpate/network/local_plane.hpp"
#include "palpate/network/model_update.hpp"
#include "palpate/network/modes.hpp"
#include "palpate/network/peer.hpp"
#include "palpate/network/port.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/stability/stability.hpp"

namespace palpate::network {

/// Options of the operator's end.
struct OperatorOptions : EndOptions {
  double rate = 1000.0;  ///< of the cycle [Hz]
  stability::Options stability;
  UpdateOptions update;
};

/// The hand at a tick; the tool follows it with scale 1 in the same axes.
struct HandInput {
  double t = 0.0;         ///< own clock [s]
  Vec3 p = Vec3::Zero();  ///< position [m]
  Vec3 v = Vec3::Zero();  ///< velocity [m/s]
  bool engaged = true;    ///< false: clutched
};

/// The objects of the scene with the parameters that arrive over the network. The model is shown as it will be when the
/// motion of this tick is executed: moving objects stand at the site's time of execution.
class LocalModel {
 public:
  /// planes: a last object is the plane of surfaces that the scene does not have.
  LocalModel(const UpdateOptions& options, scene::Snapshot scene, bool planes = false);
  /// Takes the newest estimate of one object as its goal.
  void take(const ModelEstimate& estimate) noexcept;
  /// Updates the parameters for a tool at p with this radius, at the time t of the scene [s]. v: velocity of the tool
  /// [m/s]; F: contact force on it at the last tick [N].
  void step(const Vec3& p, const Vec3& v, const Vec3& F, double radius, double t, double dt) noexcept;
  /// Moving objects are shown `ahead` of the time that step() is given, where the clock of the loop is not that of the
  /// site [s].
  void synchronise(double ahead) noexcept;
  /// The objects as they are rendered.
  [[nodiscard]] const scene::Snapshot& scene() const noexcept { return shown_; }
  [[nodiscard]] const std::vector<ModelUpdate>& updates() const noexcept { return updates_; }
  /// The parameters of an object as they are rendered.
  [[nodiscard]] ModelEstimate rendered(std::size_t i) const noexcept;

 private:
  struct Rubbing {
    double step(const Vec3& across, const Vec3& v, double K, double most, double dt) noexcept;
    double total = 0.0, highest = 0.0, kept_before = 0.0;  ///< [J]
  };

  [[nodiscard]] bool is_plane(std::size_t i) const noexcept { return planes_ && i + 1 == updates_.size(); }

  bool planes_;
  scene::Snapshot given_, shown_;
  std::vector<ModelEstimate> goals_;
  std::vector<ModelUpdate> updates_;
  std::vector<Rubbing> rubbing_;
  LocalPlane plane_;
};

/// The operator's end with its own contact and the stage `stability`.
class Operator {
 public:
  /// Throws std::invalid_argument naming an invalid option.
  Operator(const OperatorOptions& options, scene::Snapshot scene);
  void receive(const Datagram& d, double now) noexcept;
  /// One tick; returns the force on the hand [N].
  const Vec3& step(const HandInput& in) noexcept;
  /// The packet that leaves now.
  [[nodiscard]] Datagram send() const noexcept;

  [[nodiscard]] const Peer& peer() const noexcept { return peer_; }
  [[nodiscard]] const LocalModel& model() const noexcept { return model_; }
  /// True while the hand feels the remote side.
  [[nodiscard]] bool linked() const noexcept { return linked_; }

 private:
  [[nodiscard]] stability::Input of_model(const HandInput& in) noexcept;
  [[nodiscard]] stability::Input of_force() const noexcept;
  void link() noexcept;

  OperatorOptions options_;
  Peer peer_;
  LocalModel model_;
  contact::Tool contact_;
  stability::Stability stability_;
  HandInput in_;
  Vec3 F_ = Vec3::Zero(), F_contact_ = Vec3::Zero();
  Port port_;
  bool linked_ = false, free_ = true;
};

}  // namespace palpate::network
