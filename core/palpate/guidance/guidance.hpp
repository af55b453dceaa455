// Stage `guidance`: what the fixtures make of the tool's goal, and what the hand feels of them.
//
//   mapped goal -> every fixture: query -> role -> (authority) -> law -> wrench      soft: they add
//              \-> the hard ones: quadratic program -> corrected goal, and each one's share of the way there
//
// Everything is asked at the mapped goal, where the hand is: no lag of the follower is in the loop of a fixture.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/guidance/fixture.hpp"
#include "palpate/guidance/follower_model.hpp"
#include "palpate/guidance/qp.hpp"
#include "palpate/types/status.hpp"

namespace palpate::guidance {

struct Options {
  double force_rate = 20.0;   ///< of what no motion explains: a switch, an edit, another priority [N/s]
  double moment_rate = 0.35;  ///< the same of moments [N m/s]
  double return_speed =
      0.05;               ///< of the goal, where no hand moves it: out of a region that has just been forbidden [m/s]
  double reserve = 5e-5;  ///< hard fixtures keep the goal so far from the border [m]
  ServoOptions servo;     ///< of the follower behind its goal
};

/// Of an arm whose joints are known: hard corrections keep to them. All of now.
struct Joints {
  Jacobian J_WT;  ///< 6 x n, at the tool tip, in W
  JointVector q, q_min, q_max;
  JointVector step;  ///< most that each may turn in a period [rad, m]
};

/// What the stage is told at every tick. All in W.
struct Input {
  double t = 0.0;              ///< now [s]
  Pose X_WT_goal;              ///< from the mapping
  Twist V_WT;                  ///< of the tool as the hand moves it
  Pose X_WT;                   ///< measured
  bool engaged = true;         ///< the tool follows the hand: only then the hand feels anything
  Vec3 F_T_W = Vec3::Zero();   ///< what the tool touches does to it [N]
  double stiffness = 0.0;      ///< along that force; 0 when it is not known [N/m]
  double F_hand = -1.0;        ///< of the operator, measured; below zero: it is not [N]
  double pedal = 1.0;          ///< 0-1
  bool takes_damping = false;  ///< the master feels Output::B_W as such (an admittance law): it is not in the wrench
  const Joints* joints = nullptr;
};

/// What the stage answers. All in W, on the tool.
struct Output {
  Pose X_WT_goal;                  ///< corrected; exactly the mapped one where nothing hard is in the way
  Wrench F_T_W;                    ///< to be added to what is felt
  Mat3 B_W = Mat3::Zero();         ///< damping for a master that takes it as such [N s/m]
  int strongest = -1;              ///< fixture that pulls most; below zero: none does
  double gap = 0.0;                ///< of it, or of the nearest when none pulls [m, rad]
  Vec3 correction = Vec3::Zero();  ///< of the goal's place [m]
  double lent = 0.0;    ///< what fixtures that came to count more, by no motion of the hand's, store where it is [J]
  unsigned status = 0;  ///< bits of Status
};

/// A turn of 1 rad counts as so many metres [m].
inline constexpr double kLength = 0.05;

/// The gradient of what is wanted over (place, kLength turn). What turns the tool is led by turning it, never by
/// shifting it to where another attitude is wanted.
inline Vec6 row(const Want& want) noexcept {
  Vec6 a;
  a << (want.turns ? Vec3(Vec3::Zero()) : want.along.f), want.along.t / kLength;
  return a;
}

class Guidance {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  Guidance(const Options& options, double dt);

  /// From now on these, until the next ones; they outlive it. A fixture of a name that was there before goes on.
  void take(const Fixtures& fixtures) noexcept;
  /// One tick: no allocation, no lock, no exception. The answer lives until the next step.
  const Output& step(const Input& in) noexcept;
  /// Fixture i as of the last step, for whoever looks on: how much it counts, and its wrench.
  [[nodiscard]] double authority(int i) const noexcept { return part_[static_cast<std::size_t>(i)].authority; }
  [[nodiscard]] const Wrench& wrench(int i) const noexcept { return part_[static_cast<std::size_t>(i)].pull.F; }
  [[nodiscard]] double gap(int i) const noexcept { return part_[static_cast<std::size_t>(i)].want.gap; }
  /// Of all that pull now, along a force F [N/m].
  [[nodiscard]] double stiffness_along(const Vec3& F_T_W) const noexcept;

 private:
  /// A fixture's own memory and what it wants now.
  struct Part {
    std::uint64_t key = 0;   ///< of its name
    double authority = 0.0;  ///< ramped
    double rose = 0.0;       ///< by so much since the last tick
    double since = 0.0;      ///< when it was engaged [s]
    double slack = 0.0;      ///< of a hard one: what was wrong already when it came, and is being mended [m, rad]
    bool engaged = false, fresh = true;
    Want want;  ///< at the mapped goal; of a joint one along its own row, by its own share
    Pull pull;  ///< authority counted
  };
  /// A goal that keeps to fixtures all at once, and remembers its side of them.
  struct Proxy {
    Pose X_WT;
    bool known = false;
    Qp qp;
    std::array<int, Qp::kRows> of{};           ///< fixture of each row; below zero: of none
    std::array<Want, kMaxFixtures> want{};     ///< of each fixture, at the newest place
    std::array<double, kMaxFixtures> share{};  ///< of each fixture, of the way from the mapped goal [m, rad]
    std::array<Wrench, kMaxFixtures> along{};  ///< and its direction

    void add(const Vec6& a, double b, int rank, int fixture) noexcept;
  };

  [[nodiscard]] int size() const noexcept {
    return fixtures_ == nullptr ? 0 : static_cast<int>(fixtures_->fixture.size());
  }
  [[nodiscard]] const Fixture& fixture(int i) const noexcept { return fixtures_->fixture[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Part& part(int i) noexcept { return part_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool counts(int i) noexcept { return part(i).authority > 0.0; }
  [[nodiscard]] bool in(int i, bool hard) noexcept;

  [[nodiscard]] Want ask(int i, const Pose& X_WT, const Input& in) const noexcept;
  [[nodiscard]] double wanted_authority(int i, const Input& in) noexcept;
  void look(const Input& in) noexcept;
  void correct(const Input& in) noexcept;
  int add_lasting_rows(Proxy& proxy, bool hard, const Input& in) noexcept;
  bool solve(Proxy& proxy, bool hard, const Input& in) noexcept;
  void look_at(Proxy& proxy, bool hard, const Pose& X_WT, const Input& in) noexcept;
  [[nodiscard]] double lacking(const Proxy& proxy, bool hard) noexcept;
  void forgive(int i, const Want& at_goal, const Input& in) noexcept;
  void add_row(Proxy& proxy, int i, const Want& want, const Pose& X_WT, const Input& in) noexcept;
  void add_tool_row(Proxy& proxy, int i, const Input& in) noexcept;
  void invert(const Joints& joints) noexcept;
  void add_joint_rows(Proxy& proxy, const Input& in) noexcept;
  [[nodiscard]] double joints_can(const Vec6& step, const Input& in) const noexcept;
  void forget(Proxy& proxy, int from) noexcept;
  void take_shares(Proxy& proxy) noexcept;
  [[nodiscard]] double allowed(int i) noexcept;
  [[nodiscard]] double room(int i, const Want& want) noexcept;
  Pose towards(const Pose& X_WT, const Input& in) noexcept;
  void pull(const Input& in) noexcept;
  void yield(bool takes_damping) noexcept;
  void blend(const Wrench& F, const Mat3& B_W, const Input& in) noexcept;
  void tell(const Input& in) noexcept;

  Options options_;
  double dt_;
  FollowerModel follower_;
  const Fixtures* fixtures_ = nullptr;
  std::array<Part, kMaxFixtures> part_{}, old_{};
  Proxy hard_, soft_;
  Qp yield_;         ///< what gives way to whom
  Jacobian turned_;  ///< joint k turns by turned_.col(k) . y
  Pose X_before_;    ///< mapped goal of the last tick
  Twist V_before_;
  double wrong_ = 0.0;  ///< at the last goal, now: a border has moved over it [m]
  double bend_ = 0.0;   ///< what the tool's way to the goal may leave the straight line by [m]
  double lag_ = 0.0;    ///< of the corrected goal, behind a limit of speed [m]
  Vec3 lag_along_ = Vec3::Zero();
  bool started_ = false;
  Output out_;
};

}  // namespace palpate::guidance
