// Any messages in any order at any times to the cycle of networked devices: what it commands is finite, within its
// caps, and grows no faster than its rate cap.
#include <cmath>
#include <memory>

#include "bytes.hpp"
#include "palpate/loop/crtk_cycle.hpp"
#include "palpate/scene/primitives.hpp"

namespace {

using fuzz::require;
using palpate::Vec3;
using palpate::loop::ClockTime;
using palpate::loop::CrtkCycle;

palpate::loop::CrtkOptions options(fuzz::Bytes& bytes) {
  palpate::loop::CrtkOptions out;
  const unsigned bits = bytes.byte();
  out.own_teleop = (bits & 1U) != 0;
  out.tip_frame = (bits & 2U) != 0;
  out.needs_operator = (bits & 4U) != 0;
  out.needs_state = (bits & 8U) != 0;
  out.contact.radius = 0.003;
  return out;
}

palpate::scene::Snapshot floor() {
  palpate::scene::Snapshot scene;
  scene.objects.emplace_back();
  scene.objects[0].name = "floor";
  scene.objects[0].surface = std::make_shared<palpate::scene::Plane>();
  return scene;
}

struct Talk {
  CrtkCycle& cycle;
  fuzz::Bytes& bytes;
  ClockTime now{0.0, 1.7e9};
  double z = 0.01;

  double stamp() { return bytes.below(16) == 0 ? now.wall + bytes.number(1.0) : now.wall; }
  Eigen::Vector4d quaternion() {
    if (bytes.below(8) != 0) return {0.0, 0.0, 0.0, 1.0};
    const Vec3 v = bytes.vector(1.0);
    return {v.x(), v.y(), v.z(), bytes.number(1.0)};
  }
  Vec3 place() {
    z += 1e-5 * (static_cast<double>(bytes.byte()) - 128.0);
    return bytes.below(16) == 0 ? bytes.vector(0.1) : Vec3(0.0, 0.0, z);
  }
  void joints(bool leader) {
    double q[256];
    const std::size_t n = bytes.byte();
    for (std::size_t i = 0; i < n; ++i) q[i] = i < 8 ? bytes.number(2.0) : 0.0;
    if (leader)
      cycle.leader_joints(stamp(), q, n);
    else
      cycle.follower_joints(stamp(), q, n, now);
  }
  void gates() {
    const unsigned bits = bytes.byte();
    const auto on = [bits](unsigned k) { return (bits >> k & 1U) != 0; };
    // The rare states are off unless several bits agree, so that force is allowed often.
    cycle.set_gates({!on(0) || on(1), !on(1) || on(2), on(3) && on(4), true, true, on(5) && on(6), on(4) && on(7),
                     on(6) && on(7), on(0) && on(7)});
  }
  void message() {
    switch (bytes.below(10)) {
      case 0:
        return joints(true);
      case 1:
        return joints(false);
      case 2:
        return gates();
      case 3:
        return cycle.set_scale(bytes.number(1.0));
      case 4:
        return cycle.leader_twist(stamp(), {bytes.vector(0.3), bytes.vector(1.0)}, now);
      case 5:
        return (bytes.below(8) == 0 ? cycle.reset_wrench() : cycle.report(bytes.byte()));
      case 6: {
        const double angle = bytes.number(1.0);
        return bytes.below(2) == 0 ? cycle.gripper(stamp(), &angle, bytes.below(2))
                                   : cycle.jaw(stamp(), &angle, bytes.below(2));
      }
      default: {
        const Vec3 p = place();
        const Eigen::Vector4d quat = quaternion();
        cycle.leader_pose(stamp(), p, quat, now);
        cycle.follower_pose(stamp(), bytes.below(8) == 0 ? place() : p, quat, now);
      }
    }
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  CrtkCycle cycle(options(bytes), std::nullopt);
  const palpate::scene::Snapshot scene = floor();
  if (bytes.below(8) != 0) cycle.set_scene(scene);
  cycle.set_gates({true, true, false, true, true});
  const auto& caps = cycle.options().stability;
  Talk talk{cycle, bytes};
  Vec3 before = Vec3::Zero();
  for (int k = 0; k < 200 && !bytes.empty(); ++k) {
    const double dt = bytes.below(32) == 0 ? std::abs(bytes.number(0.2)) : 1e-3;
    if (std::isfinite(dt) && dt < 1e6) talk.now.t += dt, talk.now.wall += dt;
    for (std::size_t n = bytes.below(4); n > 0; --n) talk.message();
    const palpate::loop::CrtkOutput& out = cycle.step(talk.now);
    require(out.F.f.allFinite() && out.F.t.allFinite(), "the wrench is finite");
    require(out.F.f.norm() <= caps.force_cap * (1.0 + 1e-9), "the force is within its cap");
    require(out.F.t.norm() <= caps.moment_cap * (1.0 + 1e-9) + 1e-12, "the moment is within its cap");
    const double more = out.F.f.norm() - before.norm();
    require(more <= caps.rate_cap * std::max(dt, 1e-3) * (1.0 + 1e-9) + 1e-9 || !std::isfinite(dt),
            "the force grows no faster than its rate cap");
    before = out.F.f;
  }
  return 0;
}
