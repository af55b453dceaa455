// The operator's end of a link inside a loop: the tool that it sees, and what a tick records of it.
#pragma once

#include <memory>
#include <utility>

#include "palpate/loop/remote_end.hpp"
#include "palpate/loop/tick.hpp"

namespace palpate::loop {

/// Steps an end of a link once a tick. Before the tool is known it renders nothing, and the loop holds.
class Link {
 public:
  /// Takes an end; null: none.
  void attach(std::shared_ptr<RemoteEnd> end) noexcept {
    end_ = std::move(end);
    felt_ = nullptr;
    known_ = false;
  }
  /// The tool before the first tick, in W; jaw [rad].
  void begin(const Pose& X_WT, double jaw) noexcept;
  [[nodiscard]] bool attached() const noexcept { return end_ != nullptr; }
  /// What the loop renders in the tick at the time t [s]; null before the tool is known.
  const RemoteTick* step(double t) noexcept;
  /// Records the link, and keeps the tool of this tick for the other end. per_hand: energy at the hand over that at the
  /// tool [-].
  void remember(Tick& tick, double per_hand) noexcept;

 private:
  std::shared_ptr<RemoteEnd> end_;
  LocalTool tool_;
  const RemoteTick* felt_ = nullptr;  ///< of this tick
  bool known_ = false;
};

}  // namespace palpate::loop
