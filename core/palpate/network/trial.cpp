#include "palpate/network/trial.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/force/force.hpp"
#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kDt = 1e-3;     // [s] period of both ends
constexpr int kSubsteps = 10;    // of the hand per tick
constexpr double kWrong = 0.15;  // [N] error of the felt force that counts as wrong after a push
constexpr double kLong = 0.2;    // [s] for which the force must be right again
constexpr double kTouch = 0.05;  // [N] force that counts as contact

// The index of the place that is nearest to x.
std::size_t beside(const std::vector<Vec3>& places, const Vec3& x) {
  const auto nearer = [&x](const Vec3& a, const Vec3& b) { return (a - x).squaredNorm() < (b - x).squaredNorm(); };
  return static_cast<std::size_t>(std::min_element(places.begin(), places.end(), nearer) - places.begin());
}

}  // namespace

Trial::Trial(const TrialOptions& options, scene::Snapshot world, scene::Snapshot model)
    : options_(options),
      operator_(options.operator_end, model),
      site_(options.site, std::move(model)),
      instrument_(options.instrument, options.site.radius, world, options.seed + 17),
      truth_(std::move(world)),
      judge_("proxy", {.radius = options.site.radius}),
      to_site_(options.to_site, options.seed + 1),
      to_operator_(options.to_operator, options.seed + 2) {
  require("trial", !operator_.model().updates().empty(), "model", 0.0, "must have at least one object");
  require("trial", options.every >= 1, "every", options.every, "must be at least 1");
  require("trial", options.handle_mass > 0.0, "handle_mass", options.handle_mass, "must be above 0 kg");
  require("trial", options.push.t < 0.0 || options.push.object < truth_.objects.size(), "push.object",
          static_cast<double>(options.push.object), "is no object of the world");
}

double Trial::site_clock(double t) const noexcept { return options_.clock_offset + (1.0 + options_.clock_drift) * t; }

void Trial::transmit(double t) {
  ++sent_;
  if (!to_site_.send(t, operator_.send())) ++lost_;
  to_operator_.send(t, site_.send());
}

void Trial::deliver(double t) {
  to_site_.deliver(t, [this](const Datagram& d, double at) { site_.receive(d, site_clock(at)); });
  to_operator_.deliver(t, [this](const Datagram& d, double at) { operator_.receive(d, at); });
}

// Handle and hand as one mass on the arm's spring and damper, pushed by the held force.
void Trial::move_hand(const Vec3& from, const Vec3& to, double dt) noexcept {
  const double h = dt / kSubsteps, m = options_.handle_mass + options_.hand_mass;
  const Vec3 speed = (to - from) / dt;
  for (int i = 0; i < kSubsteps; ++i) {
    const Vec3 path = from + speed * (h * i);
    v_ += h / m *
          (F_ - options_.handle_damping * v_ + options_.hand_damping * (speed - v_) +
           options_.hand_stiffness * (path - x_));
    const Vec3 dx = h * v_;
    x_ += dx;
    const double work = -F_.dot(dx);
    hand_net_ += work;
    hand_in_ += std::max(work, 0.0);
  }
}

TrialResult Trial::run(const std::vector<Vec3>& path, std::vector<TrialRow>* rows) {
  begin(path.front());
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    const double t = kDt * static_cast<double>(k);
    step(t, rows);
    move(t, path[k], path[k + 1]);
  }
  return finish(kDt * static_cast<double>(path.size() - 1));
}

// The instrument has pressed a place once its force there was within the tolerance of the wanted one, and it lets go.
TrialResult Trial::palpate(const PalpationOptions& options, double most) {
  Palpation person(options);
  begin(person.aim());
  std::vector<bool> pressed(options.places.size(), false);
  bool right = false;
  double t = 0.0, began = -1.0;
  for (std::uint64_t k = 0; t < most && result_.palpated < 0.0; t = kDt * static_cast<double>(++k)) {
    step(t, nullptr);
    if (began < 0.0 && operator_.linked()) began = t;
    const Vec3 from = person.aim();
    move(t, from, person.step(F_, operator_.linked(), kDt));
    const double F = instrument_.force().norm();
    right = right || std::abs(F - options.force) <= 2.0 * options.within * options.force;
    if (right && F < kTouch) {
      right = false;
      pressed[beside(options.places, instrument_.x())] = true;
    }
    const bool all = std::all_of(pressed.begin(), pressed.end(), [](bool one) { return one; });
    if (person.done() && all) result_.palpated = t - began;
  }
  return finish(t);
}

void Trial::begin(const Vec3& x) {
  x_ = x_before_ = x;
  instrument_.place({Mat3::Identity(), x_});
  goal_.X.p = x_;
}

// Both ends and the link at the time t.
void Trial::step(double t, std::vector<TrialRow>* rows) {
  const Push& push = options_.push;
  if (!pushed_ && push.t >= 0.0 && t >= push.t) {
    pushed_ = true;
    truth_.objects[push.object].X_WO.p += push.shift;
    instrument_.world().objects[push.object].X_WO.p += push.shift;
  }
  deliver(t);
  F_before_ = F_;
  F_ = operator_.step({t, x_, v_, true});
  goal_ = site_.step(instrument_.measure(site_clock(t)), kDt);
  judge(t);
  if (ticks_++ % static_cast<std::uint64_t>(options_.every) == 0) transmit(t);
  x_before_ = x_;
  if (rows == nullptr) return;
  const ModelUpdate& update = operator_.model().updates().front();
  const Vec3 n = F_true_.norm() > 0.0 ? Vec3(F_true_.normalized()) : Vec3::UnitZ();
  rows->push_back({t, depth_, F_.dot(n), F_true_.dot(n), x_.dot(n), instrument_.x().dot(n), instrument_.force().norm(),
                   update.now().K, update.now().shift.dot(n), site_.account(), site_.playout().delay(), update.tank(),
                   hand_net_ + moved_, hand_in_ - instrument_.work(), update.now().mu, (F_ - F_true_).norm(),
                   update.now().shift.x(), update.now().shift.y(), update.now().shift.z()});
}

// Hand and instrument until the next tick.
void Trial::move(double t, const Vec3& from, const Vec3& to) {
  move_hand(from, to, kDt);
  instrument_.step(goal_, site_clock(t), kDt);
}

// The figures at the end.
TrialResult Trial::finish(double end) {
  TrialResult& r = result_;
  r.felt_over_true = true_true_ > 0.0 ? felt_true_ / true_true_ : NAN;
  r.force_rms = counted_ > 0 ? std::sqrt(error2_ / static_cast<double>(counted_)) : NAN;
  r.force_site = instrument_.largest();
  r.drift = (instrument_.x() - x_).norm();
  r.p999 = site_.peer().arrivals().p999();
  r.round_trip = site_.peer().arrivals().p50() + operator_.peer().arrivals().p50();
  r.play_delay = site_.playout().delay();
  r.clock_error = site_.peer().peer_time(site_clock(end)) - end;
  r.outages = site_.peer().arrivals().outages();
  r.lost = static_cast<double>(lost_) / static_cast<double>(std::max<std::uint64_t>(sent_, 1));
  r.touching = kDt * static_cast<double>(counted_);
  return r;
}

void Trial::judge(double t) noexcept {
  const double executed = site_clock(t + std::max(site_.playout().delay(), 0.0));
  const ContactSet& contacts = judge_.step(truth_, &x_, executed);
  F_true_ = force::step(contacts, {v_, Vec3::Zero()}, 1.0, 1.0).F;
  depth_ = contacts.size > 0 ? contacts.contact[0].depth : 0.0;
  Vec3 v_surface = Vec3::Zero();
  double K = 0.0;
  for (int i = 0; i < contacts.size; ++i) {
    const Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    v_surface = c.v_surface;
    K += c.material.K.maxCoeff();
  }
  moved_ += F_.dot(v_surface) * kDt;  // the moving surface does this work on the hand
  const double hand = hand_net_ + std::max(moved_, 0.0);
  result_.energy_hand = std::min(result_.energy_hand, hand);
  result_.energy_site = std::min(result_.energy_site, hand_in_ - instrument_.work());
  result_.energy_ports = std::min(result_.energy_ports, hand_net_ - instrument_.work());
  const bool touching = F_true_.norm() > kTouch || F_.norm() > kTouch;
  if (first_touch_ < 0.0 && instrument_.force().norm() > kTouch) first_touch_ = t;
  released_ = released_ || (first_touch_ >= 0.0 && !touching);
  const double error = (F_ - F_true_).norm();
  const double explained = (K + 2000.0) * ((x_ - x_before_).norm() + v_surface.norm() * kDt);
  result_.kick = std::max(result_.kick, (F_ - F_before_).norm() - explained);
  if (options_.push.t >= 0.0) judge_push(t, error);
  judge_outage(t);
  linked_for_ = operator_.linked() ? linked_for_ + kDt : 0.0;
  if (!touching || linked_for_ < kLong || first_touch_ < 0.0 || (options_.after_release && !released_) ||
      t < first_touch_ + 3.0 * options_.round_trip + options_.settle)
    return;
  ++counted_;
  felt_true_ += F_.dot(F_true_);
  true_true_ += F_true_.squaredNorm();
  error2_ += error * error;
}

// Time from a push until the felt force is right, and stays so.
void Trial::judge_push(double t, double error) noexcept {
  const double since = t - options_.push.t;
  if (since < 0.0) return;
  const bool touching = F_true_.norm() > kTouch || F_.norm() > kTouch;
  if (touching && error > kWrong) {
    was_wrong_ = true;
    wrong_at_ = t;
    result_.relearnt = -1.0;
  } else if (was_wrong_ && result_.relearnt < 0.0 && touching && t - wrong_at_ > kLong) {
    result_.relearnt = wrong_at_ - options_.push.t;
  }
}

// Time from the first fixed outage until the ends report it.
void Trial::judge_outage(double t) noexcept {
  if (options_.to_site.outages.empty()) return;
  const Outage& o = options_.to_site.outages.front();
  if (t < o.begin) p999_before_ = site_.peer().arrivals().p999();
  if (t < o.begin || t > o.begin + o.duration + 1.0) return;
  const bool site = site_.peer().outage();
  if (site && result_.told_site < 0.0) result_.told_site = t - o.begin - p999_before_;
  if (site && operator_.peer().outage() && result_.told < 0.0) result_.told = t - o.begin;
}

}  // namespace palpate::network
