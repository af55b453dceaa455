// The goal that hard fixtures leave, and where joint ones pull to: a quadratic program about the place of the tick
// before, so that a side once taken is kept however thin the fixture is.
//
//   y = (p - p_mapped, length * turn)      min |y|^2 / 2,   for every fixture:  gap(x) + along . (y - y_x) >= -slack
//
// asked again where its answer lies, until that is as wanted (at most kRounds times).
#include <algorithm>
#include <cmath>

#include "palpate/guidance/guidance.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr int kRounds = 6;           // of linearising and solving
constexpr double kGood = 1e-8;       // [m, rad] lacking less, a place is as wanted
constexpr double kPushed = 1e-6;     // [m] by which a border has to have moved over the goal to push it
constexpr double kFar = 0.5;         // [m] a correction beyond it is none
constexpr int kJointRank = 1 << 20;  // limits of joints come before every fixture
constexpr double kLeap = 1e-3;       // [m] that no border moves in a period
constexpr double kBend = 2.0;        // [1/m] the tool's way leaves the chord by lag^2 / (8 r), r at least 6 cm
constexpr double kMostBend = 5e-4;   // [m]
constexpr double kOfSpeed = 0.9;     // of the joints' speed: the rest is for what the Jacobian leaves out
constexpr double kDamping = 1e-3;    // of the inverse of the Jacobian, rows over kLength

/// X_b seen from X_a.
Vec6 way(const Pose& X_a, const Pose& X_b) noexcept {
  Vec6 y;
  y << X_b.p - X_a.p, kLength * rotation_vector(X_b.R * X_a.R.transpose());
  return y;
}

Pose moved(const Pose& X, const Vec6& y) noexcept {
  const Vec3 theta = y.tail<3>() / kLength;
  const double angle = theta.norm();
  return {angle > 0.0 ? Mat3(Eigen::AngleAxisd(angle, theta / angle) * X.R) : X.R, X.p + y.head<3>()};
}

bool one_sided(const Want& want) noexcept {
  return std::isfinite(want.gap) && (want.along.f != Vec3::Zero() || want.along.t != Vec3::Zero());
}

}  // namespace

void Guidance::Proxy::add(const Vec6& a, double b, int rank, int fixture) noexcept {
  const int r = qp.add(a, b, rank);
  if (r >= 0) of[to_index(r)] = fixture;
}

bool Guidance::in(int i, bool hard) noexcept {
  const Fixture& f = fixture(i);
  return counts(i) && f.policy.hard == hard && (hard || f.law->jointly());
}

void Guidance::correct(const Input& in) noexcept {
  bool any_hard = false, any_joint = false;
  for (int i = 0; i < size(); ++i) {
    any_hard |= this->in(i, true);
    any_joint |= this->in(i, false);
  }
  if (any_joint) {
    if (!soft_.known) soft_.X_WT = in.X_WT_goal;
    solve(soft_, false, in);
  }
  soft_.known = any_joint;
  if (!hard_.known) hard_.X_WT = in.X_WT_goal;
  hard_.known = true;
  if (any_hard) {
    if (!solve(hard_, true, in)) out_.status |= kGuidanceConflict;
  } else if (hard_.X_WT.p == X_before_.p && hard_.X_WT.R == X_before_.R) {
    hard_.X_WT = in.X_WT_goal;  // exactly: nothing hard is there, nor was
  } else {
    hard_.X_WT = towards(in.X_WT_goal, in);
  }
  out_.X_WT_goal = hard_.X_WT;
}

// How far from what is wanted fixture i may still be: what it found when it came is mended at the return speed, and an
// authority below one leaves its share.
double Guidance::allowed(int i) noexcept {
  const Part& now = part(i);
  return std::max(now.slack, (1.0 - now.authority) * now.want.wrong());
}

// A fixture that has just come, was edited, or leapt, may find goal and tool where they may not be: it leads them out.
void Guidance::forgive(int i, const Want& at_goal, const Input& in) noexcept {
  Part& now = part(i);
  const double pace = options_.return_speed * dt_ / (at_goal.turns ? kLength : 1.0);
  now.slack = std::max(now.slack - pace, 0.0);
  const bool leapt = at_goal.wrong() - allowed(i) > (at_goal.turns ? kLeap / kLength : kLeap);
  if (!now.fresh && !leapt) return;
  now.fresh = false;
  now.slack = std::max(at_goal.wrong(), at_goal.attracts ? 0.0 : ask(i, in.X_WT, in).wrong());
}

// What is left up to where the goal has to turn, for as long as it is held: a reserve before the border, and more while
// the tool is far behind, for its joints lead it there by an arc.
double Guidance::room(int i, const Want& want) noexcept {
  const double keep = fixture(i).policy.hard && !want.attracts ? options_.reserve + bend_ : 0.0;
  return want.gap + allowed(i) - keep - std::max(-want.drift, 0.0) * dt_;
}

// Asks all fixtures of the proxy at X; at the mapped goal they have been asked.
void Guidance::look_at(Proxy& proxy, bool hard, const Pose& X, const Input& in) noexcept {
  const bool at_goal = X.p == in.X_WT_goal.p && X.R == in.X_WT_goal.R;
  for (int i = 0; i < size(); ++i) {
    if (this->in(i, hard)) proxy.want[to_index(i)] = at_goal ? part(i).want : ask(i, X, in);
  }
}

// How much is wrong where the proxy looked last, beyond what is allowed [m].
double Guidance::lacking(const Proxy& proxy, bool hard) noexcept {
  double worst = 0.0;
  for (int i = 0; i < size(); ++i) {
    const Want& want = proxy.want[to_index(i)];
    if (!this->in(i, hard) || !one_sided(want)) continue;
    const double lacks = -room(i, want);
    worst = std::max(worst, want.turns ? kLength * lacks : lacks);
  }
  return worst;
}

// room(X) + along . (y - y_X) >= 0.
void Guidance::add_row(Proxy& proxy, int i, const Want& want, const Pose& X, const Input& in) noexcept {
  if (!one_sided(want)) return;
  const Vec6 a = row(want);
  proxy.add(a, a.dot(way(in.X_WT_goal, X)) - room(i, want), fixture(i).policy.priority, i);
}

// The tool itself is to stay out as well, though it follows its goal late.
void Guidance::add_tool_row(Proxy& proxy, int i, const Input& in) noexcept {
  if (follower_.follows_at_once()) return;
  const Want want = ask(i, in.X_WT, in);
  if (!one_sided(want) || want.attracts || want.turns) return;
  const Vec6 a = row(want);
  const double need = follower_.need(want.gap + allowed(i), want.along.f.dot(follower_.v()), want.drift);
  const Pose X = {in.X_WT_goal.R, in.X_WT.p};
  wrong_ = std::max(wrong_, need - want.along.f.dot(proxy.X_WT.p - in.X_WT.p));
  proxy.add(a, a.dot(way(in.X_WT_goal, X)) + need, fixture(i).policy.priority, i);
}

// J^+ of the joints, damped.
void Guidance::invert(const Joints& joints) noexcept {
  turned_ = joints.J_WT;
  turned_.bottomRows<3>() *= kLength;
  const Mat6 A = turned_ * turned_.transpose() + kDamping * kDamping * Mat6::Identity();
  const Eigen::LDLT<Mat6> inverse(A);
  for (Eigen::Index k = 0; k < turned_.cols(); ++k) turned_.col(k) = inverse.solve(Vec6(turned_.col(k)));
}

// The correction leaves the joints within their limits: q + J^+ (y - y_tool).
void Guidance::add_joint_rows(Proxy& proxy, const Input& in) noexcept {
  if (in.joints == nullptr) return;
  const Joints& joints = *in.joints;
  invert(joints);
  const Vec6 from = way(in.X_WT_goal, in.X_WT);
  for (Eigen::Index k = 0; k < joints.q.size(); ++k) {
    const Vec6 a = turned_.col(k);
    proxy.add(a, a.dot(from) + std::min(joints.q_min[k] - joints.q[k], 0.0), kJointRank, -1);
    proxy.add(-a, -a.dot(from) - std::max(joints.q_max[k] - joints.q[k], 0.0), kJointRank, -1);
  }
}

// The rows that stay for this tick: of joints, of the tool itself, and of what attracts, which is asked where the hand
// is. Returns how many they are.
int Guidance::add_lasting_rows(Proxy& proxy, bool hard, const Input& in) noexcept {
  proxy.qp.clear();
  if (hard) add_joint_rows(proxy, in);
  for (int i = 0; i < size(); ++i) {
    if (!this->in(i, hard)) continue;
    if (hard) add_tool_row(proxy, i, in);
    if (part(i).want.attracts) add_row(proxy, i, part(i).want, in.X_WT_goal, in);
  }
  return proxy.qp.rows();
}

bool Guidance::solve(Proxy& proxy, bool hard, const Input& in) noexcept {
  Pose X = proxy.X_WT;
  bend_ = follower_.follows_at_once() ? 0.0 : std::min(kBend * (X.p - in.X_WT.p).squaredNorm(), kMostBend);
  look_at(proxy, hard, X, in);
  for (int i = 0; i < size(); ++i) {
    if (this->in(i, hard)) forgive(i, proxy.want[to_index(i)], in);
  }
  const double lacks = lacking(proxy, hard);
  wrong_ = lacks;
  const int lasting = add_lasting_rows(proxy, hard, in);
  // What attracts adds cuts of what is wanted. What repels is asked about the place before, and anew about each better
  // one: its side is remembered.
  Qp::Status status = Qp::Status::solved;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < size(); ++i) {
      if (!this->in(i, hard)) continue;
      const Want& want = proxy.want[to_index(i)];
      if (!want.attracts || (round > 0 && want.wrong() > allowed(i) + kGood)) add_row(proxy, i, want, X, in);
    }
    status = proxy.qp.solve(Vec6::Zero());
    const Vec6& y = proxy.qp.y();
    if (!(y.norm() < kFar)) return false;  // the goal stays where it was
    X = moved(in.X_WT_goal, y);
    if (status == Qp::Status::stopped || round + 1 == kRounds) break;
    look_at(proxy, hard, X, in);
    if (lacking(proxy, hard) < kGood || proxy.qp.rows() + size() > Qp::kRows) break;
    forget(proxy, lasting);
  }
  take_shares(proxy);
  // As wanted already, the place is left for a nearer one alone: at rest it stands still.
  const Vec6 stays = way(in.X_WT_goal, proxy.X_WT);
  if (lacks < kGood && stays.norm() <= proxy.qp.y().norm() && proxy.qp.kept(stays, lasting)) X = proxy.X_WT;
  if (hard) {
    X = towards(X, in);
    // What had to be slowed down is pushed all the same, by a border that has moved over it.
    if (wrong_ > kPushed && proxy.qp.solve(way(in.X_WT_goal, X)) != Qp::Status::stopped && proxy.qp.y().norm() < kFar) {
      X = moved(in.X_WT_goal, proxy.qp.y());
    }
  }
  proxy.X_WT = X;
  return status == Qp::Status::solved;
}

// A row that promised less than is found where it led to bulges the other way than its border: it would forbid what is
// allowed. One that promised more stays beside the newer: where walls meet, each has its own.
void Guidance::forget(Proxy& proxy, int from) noexcept {
  int rows = from;
  for (int r = from; r < proxy.qp.rows(); ++r) {
    const int i = proxy.of[to_index(r)];
    const Want& want = proxy.want[to_index(i)];
    if (!want.attracts && proxy.qp.slack(r) < room(i, want)) continue;
    proxy.of[to_index(rows)] = i;
    proxy.qp.move(r, rows++);
  }
  proxy.qp.truncate(rows);
}

// Each fixture's share of the way from the mapped goal, y = sum of multipliers times rows, as one row of their size.
void Guidance::take_shares(Proxy& proxy) noexcept {
  std::array<double, kMaxFixtures> sum{}, squares{};
  for (int i = 0; i < size(); ++i) proxy.share[to_index(i)] = 0.0, proxy.along[to_index(i)] = {};
  for (int r = 0; r < proxy.qp.rows(); ++r) {
    const int i = proxy.of[to_index(r)];
    const double pushes = proxy.qp.multiplier(r);
    if (i < 0 || pushes <= 0.0) continue;
    const Vec6 a = proxy.qp.row(r);
    sum[to_index(i)] += pushes;
    squares[to_index(i)] += pushes * a.squaredNorm();
    Wrench& along = proxy.along[to_index(i)];
    along = along + Wrench{pushes * a.head<3>(), pushes * kLength * a.tail<3>()};
  }
  for (int i = 0; i < size(); ++i) {
    if (sum[to_index(i)] == 0.0) continue;
    Wrench& along = proxy.along[to_index(i)];
    const double size = std::sqrt(squares[to_index(i)] / sum[to_index(i)]);
    const double way = std::sqrt(along.f.squaredNorm() + (along.t / kLength).squaredNorm());
    along = {size / way * along.f, size / way * along.t};
    proxy.share[to_index(i)] = size * way;
    if (part(i).want.turns) along.f = part(i).want.along.f;  // that the aim turns with the place is felt all the same
  }
}

// The share of a step of the goal that the joints can take in a period: beyond it each would go its own way.
double Guidance::joints_can(const Vec6& step, const Input& in) const noexcept {
  double share = 1.0;
  if (in.joints == nullptr || turned_.cols() != in.joints->step.size()) return share;
  for (Eigen::Index k = 0; k < in.joints->step.size(); ++k) {
    const double turn = std::abs(turned_.col(k).dot(step)), most = kOfSpeed * in.joints->step[k];
    if (turn > most) share = std::min(share, most / turn);
  }
  return share;
}

// From the goal before towards X_WT: as fast as the hand moves, and by the return speed beside; no faster than a limit
// of speed and the joints let it.
Pose Guidance::towards(const Pose& X_WT, const Input& in) noexcept {
  const Pose& X = hard_.X_WT;
  double most = way(X_before_, in.X_WT_goal).norm() + options_.return_speed * dt_;
  double speed = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size(); ++i) {
    if (this->in(i, true)) speed = std::min(speed, part(i).want.speed);
  }
  const Vec6 step = way(X, X_WT);
  const double far = step.norm();
  most = std::min({most, speed * dt_, far * joints_can(step, in)});
  lag_ = 0.0;
  if (far <= most) return X_WT;
  const Pose reached = moved(X, most / far * step);
  const Vec3 behind = reached.p - X_WT.p;
  if (speed * dt_ <= most && behind.norm() > 0.0) lag_ = behind.norm(), lag_along_ = behind / lag_;
  return reached;
}

}  // namespace palpate::guidance
