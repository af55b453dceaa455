// Both ends, the link and an instrument inside of one loop: a session across an emulated network, in virtual time.
#pragma once

#include <cstdint>

#include "palpate/network/follower.hpp"
#include "palpate/network/loop_end.hpp"
#include "palpate/network/wire.hpp"

namespace palpate::network {

/// Options of an emulated remote site.
struct EmulatedOptions {
  LoopEndOptions operator_end;
  FollowerOptions follower;        ///< with the rate of the loop [Hz]
  Condition to_site, to_operator;  ///< both directions of the link
  std::uint64_t seed = 0;          ///< of the link
};

/// The operator's end of a link whose other end is here as well. Its clock is the time of the loop, so the same seed
/// gives the same record.
class EmulatedEnd final : public loop::RemoteEnd {
 public:
  /// scene: the objects as both ends have them; world: as they really are. Throws std::invalid_argument.
  EmulatedEnd(const EmulatedOptions& options, const scene::Snapshot& scene, scene::Snapshot world);
  const loop::RemoteTick& step(const loop::LocalTool& tool) noexcept override;
  /// For other threads: the state after the newest tick.
  [[nodiscard]] LinkState state() { return end_.state(); }

 private:
  LoopEnd end_;
  Site site_;
  Instrument instrument_;
  Wire to_site_, to_operator_;
  double dt_;
  bool started_ = false;
};

}  // namespace palpate::network
