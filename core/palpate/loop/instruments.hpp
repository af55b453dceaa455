// Several instruments in one world: every loop publishes its own instrument and reads those of the others. No loop
// waits for another: a loop that stalls leaves its instrument at rest where it was last seen.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "palpate/arm/arm.hpp"
#include "palpate/contact/capsules.hpp"
#include "palpate/contact/contact.hpp"
#include "palpate/loop/bodies.hpp"
#include "palpate/loop/held_object.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::loop {

/// Maximum number of instruments in one world.
inline constexpr int kMaxInstruments = 8;

/// A capsule of an instrument: its axis runs from the centre of one sphere to that of another, on any link.
struct ToolCapsule {
  contact::ToolSphere a, b;
  double radius = 0.002;  ///< [m]
};

/// An instrument with its grip on the rod of the world.
struct Published {
  contact::Instrument instrument;
  Grip grip;
};

/// Mailboxes between the loops of one world: one for each ordered pair of writer and reader.
class Board {
 public:
  explicit Board(int size, const RodOptions& rod = {})
      : size_(size), rod_(rod), boxes_(to_index(size) * to_index(size)) {}
  [[nodiscard]] int size() const noexcept { return size_; }
  /// The rod that the instruments can hold.
  [[nodiscard]] const RodOptions& rod() const noexcept { return rod_; }
  /// A number larger than all before.
  [[nodiscard]] std::uint64_t order() noexcept { return order_.fetch_add(1, std::memory_order_relaxed) + 1; }
  void write(int writer, const Published& published) noexcept;
  [[nodiscard]] const Published& read(int writer, int reader) noexcept { return boxes_[box(writer, reader)].read(); }

 private:
  [[nodiscard]] std::size_t box(int writer, int reader) const noexcept {
    return to_index(writer) * to_index(size_) + to_index(reader);
  }

  int size_;
  RodOptions rod_;
  std::atomic<std::uint64_t> order_{0};
  std::vector<Mailbox<Published>> boxes_;
};

/// Forces of the other instruments on one tool.
struct OnTool {
  Wrench F_T_W;                  ///< wrench about the tool tip T, in W
  double stiffness = 0.0;        ///< stiffness of the touching instruments together [N/m]
  double power = 0.0;            ///< of their motion on the tool [W]
  Vec3 F_held_W = Vec3::Zero();  ///< part of the force that comes from the rod, which another instrument holds too [N]
  Holding holding = Holding::none;                              ///< how the tool holds the rod
  Pose X_WO;                                                    ///< pose of the rod
  double gap = std::numeric_limits<double>::infinity();         ///< smallest distance to another instrument [m]
  double handle_gap = std::numeric_limits<double>::infinity();  ///< smallest distance between two handles [m]

  /// Adds the coupling with the rigid bodies of the scene.
  void add(const BodyContact& bodies) noexcept;
  /// Writes the signals of other instruments to a tick.
  void record(Tick& tick) const noexcept;
};

/// Measured place of an instrument, from which its capsules follow.
struct InstrumentState {
  Vec3 p_WH;                           ///< position of the leader's handle [m]
  Pose X_WT;                           ///< tool
  Pose X_WA;                           ///< base of the follower's model
  const arm::Arm* follower = nullptr;  ///< the model at the measured joint positions
  double jaw = 0.0;                    ///< jaw angle [rad]
  double rate = 0.0;                   ///< inverse of the time since the last state; 0: the velocity is unknown [Hz]
  double share = 1.0;  ///< coefficient of the low-pass for velocities, see low_pass_coefficient(); 1: no filter
};

/// One instrument of a world, published by its loop and pushed by the other instruments.
class InWorld {
 public:
  /// links: number of links of the follower. Throws std::invalid_argument naming an invalid value.
  InWorld(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules, contact::InstrumentLaw law,
          int links);

  /// Shows the instrument to the other loops. Called by the loop between two ticks; `at` must be finite.
  void publish(const InstrumentState& at) noexcept;
  /// How the tool holds the rod, and where the rod is.
  [[nodiscard]] const HeldObject& rod() const noexcept { return rod_; }
  /// Wrench of the other instruments on the tool as published.
  [[nodiscard]] const OnTool& step() noexcept;

 private:
  [[nodiscard]] const contact::Instrument& seen(int other) noexcept;
  void hold(const Pose& X_WT) noexcept;
  [[nodiscard]] std::span<const Grip> other_grips() noexcept;

  std::shared_ptr<Board> board_;
  int index_;
  std::vector<ToolCapsule> capsules_;
  contact::InstrumentLaw law_;
  Vec3 p_WT_ = Vec3::Zero();
  HeldObject rod_;
  Published published_;
  contact::Instrument& own_ = published_.instrument;
  std::array<Grip, kMaxInstruments> grips_;  ///< of the other instruments
  std::array<contact::Instrument, kMaxInstruments> other_;
  std::array<int, kMaxInstruments> silent_{};  ///< ticks since the other instrument was last published
  std::array<contact::InstrumentPair, kMaxInstruments> pair_;
  std::array<contact::Push, contact::kMaxCapsulePairs> pushes_;
  OnTool out_;
};

}  // namespace palpate::loop
