// A simulated teleoperation in virtual time: a hand, both ends, the link and an instrument; and its judge.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/network/instrument.hpp"
#include "palpate/network/operator.hpp"
#include "palpate/network/palpation.hpp"
#include "palpate/network/site.hpp"
#include "palpate/network/wire.hpp"

namespace palpate::network {

/// An object that is pushed aside during a trial.
struct Push {
  double t = -1.0;  ///< [s]; negative: never
  std::size_t object = 0;
  Vec3 shift = Vec3::Zero();  ///< [m]
};

/// Options of a trial.
struct TrialOptions {
  OperatorOptions operator_end;
  SiteOptions site;
  InstrumentOptions instrument;
  Condition to_site, to_operator;  ///< both directions of the link
  int every = 1;                   ///< ticks between two packets of each end
  double handle_mass = 0.3;        ///< [kg]
  double handle_damping = 0.5;     ///< [N s/m]
  double hand_mass = 0.1, hand_damping = 5.0, hand_stiffness = 300.0;
  double clock_offset = 3.7;   ///< of the site's clock [s]
  double clock_drift = 2e-5;   ///< [-]
  double settle = 0.5;         ///< forces count this long after the first touch and three round trips [s]
  double round_trip = 0.0;     ///< nominal, for that time [s]
  bool after_release = false;  ///< true: forces count once the first touch has ended as well
  Push push;
  std::uint64_t seed = 0;
};

/// Figures of a trial. Energies are by quadrature over the substeps of hand and instrument, and forces are compared
/// with the force of the true surface on a tool at the hand's position, when its motion is executed.
struct TrialResult {
  double energy_hand = 0.0;     ///< lowest energy that the hand has put in, less the work of moving surfaces [J]
  double energy_site = 0.0;     ///< lowest of: gross energy of the hand less net work on the tissue [J]
  double energy_ports = 0.0;    ///< lowest of: net energy of the hand less net work on the tissue [J]
  double felt_over_true = 0.0;  ///< slope of the felt over the true force [-]; NaN without contact
  double force_rms = 0.0;       ///< rms of their difference in contact [N]
  double force_site = 0.0;      ///< largest force on the tissue [N]
  double kick = 0.0;            ///< largest change of the force per tick that no motion explains [N]
  double drift = 0.0;           ///< distance of instrument and hand at the end [m]
  double relearnt = -1.0;       ///< time after the push until the felt force is right again; negative: never [s]
  double told = -1.0;           ///< time of the first outage until both ends have reported it; negative: never [s]
  double p999 = 0.0;            ///< 99.9th percentile of the age at the site [s]
  double told_site = -1.0;      ///< time until the site has reported it, beyond p999 before it [s]
  double round_trip = 0.0;      ///< sum of the median ages of both directions [s]
  double play_delay = 0.0;      ///< at the end [s]
  double clock_error = 0.0;     ///< of the site's estimate at the end [s]
  int outages = 0;              ///< reported by the site
  double lost = 0.0;            ///< share of lost packets to the site [-]
  double touching = 0.0;        ///< time in contact that counted [s]
  double palpated = -1.0;       ///< time from the link to the last press of the instrument; negative: not in time [s]
};

/// A row per tick.
struct TrialRow {
  double t, depth, felt, truth, x_hand, x_site, F_site, K, shift, account, play_delay, tank, energy_hand, energy_site,
      mu, error, shift_x, shift_y, shift_z;
};

/// Runs a trial: path holds the hand's intended position at every tick [m]; it begins out of contact.
class Trial {
 public:
  /// world: the objects as they are; model: as both ends have them. Throws std::invalid_argument.
  Trial(const TrialOptions& options, scene::Snapshot world, scene::Snapshot model);
  TrialResult run(const std::vector<Vec3>& path, std::vector<TrialRow>* rows = nullptr);
  /// A simulated person palpates, for at most `most` [s]; call either this or run(), once.
  TrialResult palpate(const PalpationOptions& options, double most);

 private:
  [[nodiscard]] double site_clock(double t) const noexcept;
  void begin(const Vec3& x);
  void step(double t, std::vector<TrialRow>* rows);
  void move(double t, const Vec3& from, const Vec3& to);
  TrialResult finish(double t);
  void transmit(double t);
  void deliver(double t);
  void move_hand(const Vec3& from, const Vec3& to, double dt) noexcept;
  void judge(double t) noexcept;
  void judge_outage(double t) noexcept;
  void judge_push(double t, double error) noexcept;

  TrialOptions options_;
  Operator operator_;
  Site site_;
  Instrument instrument_;
  scene::Snapshot truth_;  ///< what the judge compares with
  contact::Tool judge_;
  Wire to_site_, to_operator_;
  std::uint64_t sent_ = 0, lost_ = 0;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero(), F_ = Vec3::Zero(), F_before_ = Vec3::Zero(), x_before_ = Vec3::Zero();
  double hand_in_ = 0.0, hand_net_ = 0.0, moved_ = 0.0, first_touch_ = -1.0;
  double felt_true_ = 0.0, true_true_ = 0.0, error2_ = 0.0, wrong_at_ = -1.0, p999_before_ = 0.0, linked_for_ = 0.0;
  Vec3 F_true_ = Vec3::Zero();
  double depth_ = 0.0;
  long counted_ = 0;
  std::uint64_t ticks_ = 0;
  bool pushed_ = false, was_wrong_ = false, released_ = false;
  SiteGoal goal_;
  TrialResult result_;
};

}  // namespace palpate::network
