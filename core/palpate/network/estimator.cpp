#include "palpate/network/estimator.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kFelt = 0.06;       // [N] smaller forces are no contact
constexpr double kMissing = 0.2;     // [N] predicted force from which a contact that is not felt tells something
constexpr double kPressed = 0.15;    // [N] normal force from which the force across it tells something
constexpr double kFriction = 0.3;    // [-] standard deviation of an unknown friction coefficient
constexpr double kUneven = 0.025;    // [-] error of the force across the normal, as a share of the normal force
constexpr double kUnsettled = 0.2;   // [-] the same, as a share of the error along the normal
constexpr double kCorrelated = 4.0;  // [measurements] for which these errors last
constexpr double kBend = 0.5;        // [-] share of the second differences that counts as error
constexpr double kExpected = 6.0;    // [-] squared innovation over its variance that needs no other cause
constexpr double kSettling = 0.3;    // weight of a new contradiction across the normal
constexpr int kContradicted = 10;    // [measurements] until such contradictions tell that the place there is wrong
constexpr double kReopened = 1e-3;   // [m] standard deviation that the place across the normal gains then
constexpr double kLeastAside = 1e-4, kMostAside = 1.5e-3;  // [m] of a perturbed place
// Random walk per measurement across the normal: place 0.3 mm and friction 0.05 in the square root of a second.
constexpr double kWalkAcross = 9e-8 * 4e-3, kWalkMu = 2.5e-3 * 4e-3;
constexpr double kLeastVariance = 1e-16;  // of a direction that is known
constexpr double kSurprise = 5.0;         // [standard deviations]
constexpr int kSurprised = 25;            // [ticks]
constexpr int kRest = 60;                 // [ticks] after a surprise, until the next
constexpr double kAstray = 0.7;           // share of the force that a lost estimate leaves unexplained
constexpr int kLost = 200;                // [ticks] for which it does
constexpr double kForget = 0.01;          // weight of a new residual
constexpr double kLeast = 1.0;            // [N/m] smallest stiffness
// Random walk of theta per tick: stiffness 2 N/m, place 2 um and damping .05 N s/m in the square root of a second.
constexpr double kWalkK = 4.0 * 1e-3, kWalkPlace = 4e-12 * 1e-3, kWalkB = 2.5e-3 * 1e-3;

}  // namespace

Estimator::Estimator(const EstimatorOptions& options) : options_(options) {
  require("remote", options.K > 0.0, "stiffness", options.K, "must be above 0 N/m");
  require("remote", options.sd_force > 0.0, "sd_force", options.sd_force, "must be above 0 N");
  begin();
}

// Nothing but the options is known.
void Estimator::begin() noexcept {
  const EstimatorOptions& options = options_;
  theta_ << options.K, 0.0, 0.0, 0.0, 0.0, 0.0;
  const double place = options.K * options.sd_place;
  Vec variance;
  variance << options.sd_K * options.sd_K, place * place, place * place, place * place, 1.0, kFriction * kFriction;
  P_ = variance.asDiagonal();
  normal_ = options.normal;
  if (options.sd_along >= 0.0) {
    const double along = options.K * options.sd_along;
    P_.block<3, 3>(1, 1) += (along * along - place * place) * normal_ * normal_.transpose();
  }
  spread();
}

Estimator::Vec Estimator::row(const Touch& t) noexcept {
  Vec h;
  h << t.depth, t.normal, -t.v.dot(t.normal), 0.0;
  return h;
}

double Estimator::predicted(const Touch& touch) const noexcept { return std::max(row(touch).dot(theta_), 0.0); }

bool Estimator::step(const Touch& touch, const Prediction& prediction) noexcept {
  if (!touch.F.allFinite() || !std::isfinite(touch.depth) || !touch.v.allFinite()) return false;
  const Vec h = row(touch);
  const double measured = touch.F.dot(touch.normal), prior = h.dot(theta_);
  const bool felt = measured > kFelt;
  if (lost(touch, prediction, prior)) return true;
  if (!felt && prior <= kMissing) return false;  // both agree that there is no contact, within the noise
  normal_ = touch.normal;
  learn_across(touch, prediction);
  const double z = felt ? measured : 0.0;
  // Where the force points elsewhere, the normal is wrong, and so is what the force along it seems to tell.
  const double sd = felt ? options_.sd_force + options_.sd_model * measured + contradiction_ : kMissing / 2.0;
  const double innovation = z - prior, S = h.dot(P_ * h) + sd * sd;
  residual2_ += kForget * (innovation * innovation - residual2_);
  rest_ = std::max(rest_ - 1, 0);
  const bool surprise = innovation * innovation > kSurprise * kSurprise * S;
  surprised_ = surprise && rest_ == 0 ? surprised_ + 1 : std::max(surprised_ - 1, 0);
  if (surprised_ >= kSurprised) forget_place();
  if (felt) {
    measure(h, innovation, sd);
  } else {
    recede(touch.normal, prior);
  }
  const double place = theta_[0] * theta_[0] * kWalkPlace;
  P_.diagonal() += (Vec() << kWalkK, place, place, place, kWalkB, 0.0).finished();
  if (prediction.across && felt) {
    const Mat3 across = Mat3::Identity() - touch.normal * touch.normal.transpose();
    P_.block<3, 3>(1, 1) += kWalkAcross * theta_[0] * theta_[0] * across;
    P_(5, 5) += kWalkMu;
  }
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  spread();
  return true;
}

// Updates theta by one scalar measurement with the row h and this standard deviation.
void Estimator::measure(const Vec& h, double innovation, double sd) noexcept {
  const Vec Ph = P_ * h;
  const Vec gain = Ph / (h.dot(Ph) + sd * sd);
  theta_ += gain * innovation;
  P_ -= gain * Ph.transpose();
  bound();
}

// Keeps the parameters where they have a meaning.
void Estimator::bound() noexcept {
  theta_[0] = std::max(theta_[0], kLeast);
  theta_[4] = std::max(theta_[4], 0.0);
  theta_[5] = std::clamp(theta_[5], 0.0, 2.0);
}

// The tool is where the estimate has a contact of the force `prior`, and feels nothing: the surface is no nearer than
// the tool. A bound is no measurement: it moves the place, and leaves all variances, stiffness, damping and friction.
void Estimator::recede(const Vec3& normal, double prior) noexcept {
  Vec h = Vec::Zero();
  h.segment<3>(1) = normal;
  const Vec Ph = P_ * h;
  const double share = prior / (h.dot(Ph) + 0.25 * kMissing * kMissing);
  theta_.segment<3>(1) -= share * Ph.segment<3>(1);
}

// The object has moved: its place is as unknown as most_shift allows, and its stiffness is kept.
void Estimator::forget_place() noexcept {
  surprised_ = 0;
  rest_ = kRest;
  ++moved_;
  const double place = theta_[0] * 0.5 * options_.most_shift;
  P_.block<1, 3>(0, 1).setZero();
  P_.block<3, 1>(1, 0).setZero();
  P_.block<3, 3>(1, 1) += Mat3::Identity() * place * place;
}

// True if the estimate leaves most of the force unexplained for so long that it has run away; it then begins anew, and
// the margin tells what was unexplained. Such an estimate is too far from the truth for its slopes to lead back.
bool Estimator::lost(const Touch& touch, const Prediction& prediction, double prior) noexcept {
  const double force = touch.F.norm();
  if (force < kPressed) return false;
  const Vec3 expected = prediction.touching ? prediction.F : Vec3(std::max(prior, 0.0) * touch.normal);
  const double unexplained = (touch.F - expected).norm();
  const bool astray = unexplained > kAstray * force;
  lost_ = astray ? lost_ + 1 : std::max(lost_ - 1, 0);
  if (lost_ < kLost) return false;
  lost_ = surprised_ = contradicted_ = 0;
  contradiction_ = 0.0;
  residual2_ = std::max(residual2_, unexplained * unexplained);
  rest_ = kRest;
  ++moved_;
  normal_ = touch.normal;
  begin();
  return true;
}

void Estimator::wander(double along, double across) noexcept {
  const Mat3 out = normal_ * normal_.transpose();
  P_.block<3, 3>(1, 1) += theta_[0] * theta_[0] * (along * out + across * (Mat3::Identity() - out));
}

// K (shift - now) = K shift - now K: linear in theta.
Vec3 Estimator::recentre() noexcept {
  const Vec3 now = theta_.segment<3>(1) / theta_[0];
  Mat T = Mat::Identity();
  T.block<3, 1>(1, 0) = -now;
  theta_.segment<3>(1).setZero();
  P_ = (T * P_ * T.transpose()).eval();
  return now;
}

void Estimator::turn(const Mat3& R) noexcept {
  Mat T = Mat::Identity();
  T.block<3, 3>(1, 1) = R;
  P_ = (T * P_ * T.transpose()).eval();
  normal_ = R * normal_;
  spread();
}

// The place across the normal becomes less certain than the slopes so far made it, up to what it was at first.
void Estimator::reopen(const Vec3& normal) noexcept {
  contradicted_ = 0;
  const Mat3 across = Mat3::Identity() - normal * normal.transpose();
  const double place = theta_[0] * options_.sd_place, more = theta_[0] * kReopened;
  if ((across * P_.block<3, 3>(1, 1)).trace() < kAcross * place * place) P_.block<3, 3>(1, 1) += more * more * across;
}

// Place and friction from the force across the normal.
void Estimator::learn_across(const Touch& touch, const Prediction& prediction) noexcept {
  const double normal = touch.F.dot(touch.normal), off = normal - prediction.F.dot(touch.normal);
  if (normal < kPressed) contradiction_ = 0.0;
  if (!prediction.across || normal < kPressed) return;
  Eigen::Matrix<double, 3, 2> tangents;
  tangents.col(0) = touch.normal.unitOrthogonal();
  tangents.col(1) = touch.normal.cross(tangents.col(0));
  const double sd = options_.sd_force + kUneven * normal + kUnsettled * std::abs(off);
  Eigen::Matrix2d S = kCorrelated * sd * sd * Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, kN, kAcross + 1> C;
  Eigen::Matrix<double, kAcross + 1, 2> slope;  // per standard deviation
  const auto blur = [&](const Vec3& bend) {
    const Eigen::Vector2d across = tangents.transpose() * bend;
    S += kBend * across * across.transpose();
  };
  for (int j = 0; j <= kAcross; ++j) {
    const auto k = static_cast<std::size_t>(j);
    const Column& c = column_[k];
    C.col(j) = c.sd;
    Vec3 change = c.sd[5] * prediction.per_mu;
    if (j < kAcross) {
      change += (prediction.above[k] - prediction.below[k]) / (2.0 * c.part);
      blur((prediction.above[k] + prediction.below[k] - 2.0 * prediction.F) / c.part);
    } else {
      blur(c.sd[5] * prediction.bend);
    }
    slope.row(j) = (tangents.transpose() * change).transpose();
  }
  S += slope.transpose() * slope;
  const Eigen::Vector2d innovation = tangents.transpose() * (touch.F - prediction.F);
  // A force that the model does not explain counts less.
  const double apart = innovation.dot(S.inverse() * innovation) / kExpected;
  contradiction_ += kSettling * (std::max(innovation.norm() - 2.0 * sd, 0.0) - contradiction_);
  contradicted_ = apart > 1.0 ? contradicted_ + 1 : std::max(contradicted_ - 1, 0);
  if (contradicted_ >= kContradicted) reopen(touch.normal);
  if (apart > 1.0) S *= apart;
  const Eigen::Matrix<double, kN, 2> covariance = C * slope, gain = covariance * S.inverse();
  theta_ += gain * innovation;
  P_ -= gain * covariance.transpose();
  bound();
}

// Chooses the next perturbations: standard deviations along two tangents, then what they leave of that of friction,
// each with what it implies for the other parameters, and within the lengths over which differences make sense.
void Estimator::spread() noexcept {
  Mat left = P_;
  const Vec3 e = std::abs(normal_.x()) < 0.7 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
  const Vec3 along = (e - normal_ * normal_.dot(e)).normalized();
  for (int j = 0; j <= kAcross; ++j) {
    Vec g = Vec::Unit(5);
    if (j < kAcross) g << 0.0, j == 0 ? along : Vec3(normal_.cross(along)), 0.0, 0.0;
    const Vec covariance = left * g;
    const double sd = std::sqrt(std::max(g.dot(covariance), kLeastVariance));
    Column& c = column_[static_cast<std::size_t>(j)];
    c.sd = covariance / sd;
    left -= c.sd * c.sd.transpose();
    c.part = std::clamp(sd / theta_[0], kLeastAside, kMostAside) * theta_[0] / sd;
  }
}

Guess Estimator::guess(int j, int side) const noexcept {
  const Column& c = column_[static_cast<std::size_t>(j)];
  const Vec theta = theta_ + side * c.part * c.sd;
  const double K = std::max(theta[0], 0.5 * theta_[0]);
  return {theta.segment<3>(1) / K, K};
}

ModelEstimate Estimator::estimate() const noexcept {
  ModelEstimate out;
  out.K = theta_[0];
  out.B = theta_[4];
  out.shift = theta_.segment<3>(1) / theta_[0];
  const double most = options_.most_shift;
  if (out.shift.norm() > most) out.shift *= most / out.shift.norm();
  out.mu = theta_[5];
  out.sd_K = std::sqrt(std::max(P_(0, 0), 0.0));
  // Along the last normal: d(K shift . n) - shift . n dK, divided by K.
  Vec g = Vec::Zero();
  g.segment<3>(1) = normal_;
  g[0] = -out.shift.dot(normal_);
  out.sd_shift = std::sqrt(std::max(g.dot(P_ * g), 0.0)) / theta_[0];
  out.margin = std::sqrt(residual2_);
  return out;
}

}  // namespace palpate::network
