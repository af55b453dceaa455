// Console and pedals: operator presence and pedals start and stop the teleoperations. It simulates the two consoles of
// sawIntuitiveResearchKit: with pedals only, where the coag pedal reports the operator's presence, and with a head
// sensor, which reports it and leaves the coag pedal free.
#pragma once

#include <array>
#include <vector>

#include "dvrk/camera_teleop.hpp"
#include "dvrk/endoscope_focus.hpp"
#include "dvrk/teleop.hpp"

namespace palpate::dvrk {

/// Console with operator presence and pedals.
class Console {
 public:
  /// Keeps the addresses of the arms and teleops. head_sensor: presence comes from a head sensor, which
  /// emulate_operator_present sets; otherwise from the coag pedal.
  Console(std::vector<SimulatedArm*> mtms, std::vector<Teleop*> teleops, CameraTeleop* camera, EndoscopeFocus* focus,
          bool head_sensor, Outbox& out);

  void start() noexcept;                        ///< publishes the first states
  bool apply(const Command& command) noexcept;  ///< applies a command; false if the console has no such verb
  void run(double t, double dt) noexcept;       ///< one period, which ends at t [s]; tells presses from taps

 private:
  /// State of a pedal; told: the press has been reported.
  struct Pedal {
    Topic topic = Topic::pedal_clutch;
    bool down = false, reported = false;
    double since = 0.0;
  };
  void press(std::size_t pedal, int button) noexcept;
  void report(std::size_t pedal, int button) noexcept;
  void operator_present(int button) noexcept;
  void clutch(int button) noexcept;
  void camera(int button) noexcept;
  void select(const Text& name, bool selected) noexcept;
  void tell_selection() noexcept;
  void set_scale(double scale) noexcept;
  void update() noexcept;
  void run_teleops(std::string_view command) noexcept;
  void hold_mtms() noexcept;

  std::vector<SimulatedArm*> mtms_;
  std::vector<Teleop*> teleops_;
  std::vector<bool> selected_;
  CameraTeleop* camera_teleop_;
  EndoscopeFocus* focus_;  ///< moved by the pedals cam_plus and cam_minus; nullptr: no endoscope
  EventPublisher publisher_, pedal_publisher_;
  std::array<Pedal, 6> pedals_;
  bool head_sensor_;
  bool enabled_ = false, present_ = false, camera_ = false;
  bool psm_running_ = false, camera_running_ = false;
};

}  // namespace palpate::dvrk
