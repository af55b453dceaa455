#include "palpate/verify/tissue_soak.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/loop/soft_objects.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/random.hpp"

namespace palpate::verify {
namespace {

constexpr double kSoftTick = 1e-3;    // [s] period of a tick
constexpr double kAway = 10.0;        // [m] where a sphere that takes no part is parked
constexpr double kReach = 3.0;        // [r] contact may be lost where the deflection is below this, at 1 m/s
constexpr double kMoved = 0.1;        // [edge] displacement of a node that is at rest
constexpr double kSoftPause = 20e-3;  // [s] pause between two actions

using Centres = std::array<Vec3, 2>;

/// Drawn values of an action: the places of both spheres, way point by way point.
struct Action {
  std::vector<Centres> way;
  double speed = 0.1, limit = 3.0, friction = 0.0;
  bool hard = false, held = false;
};

class TissueSoak {
 public:
  TissueSoak(const tissue::SoftSurface& surface, std::uint64_t seed, double held_below, const TissueSoakRange& range)
      : range_(range),
        held_below_(held_below),
        random_(seed),
        soft_(std::static_pointer_cast<tissue::SoftSurface>(surface.at_rest())),
        tool_("proxy", options(range.radius)) {
    scene_.objects.resize(1);
    scene_.objects[0].surface = soft_;
    rest_.assign(soft_->mesh()->vertices().begin(), soft_->mesh()->vertices().end());
    const Vec3 away(kAway, kAway, kAway);
    tip_ = {away, away + Vec3(1.0, 0.0, 0.0)};
  }

  TissueSoakReport run(std::int64_t actions) {
    for (std::int64_t i = 0; i < actions; ++i) {
      const Action action = draw();
      perform(action);
      if (action.hard || (i + 1) % range_.rest_every == 0) check_rest();
    }
    check_rest();
    return out_;
  }

 private:
  static contact::Options options(double radius) {
    contact::Options o;
    o.radius = radius;
    o.spheres = {{.radius = radius}};
    return o;
  }
  double between(double low, double high) { return low + (high - low) * uniform(random_); }

  /// A random point of the surface above the held part, with its normal.
  scene::Nearest target() {
    const std::size_t count = rest_.size() / 3;
    for (;;) {
      const auto i = static_cast<std::size_t>(uniform(random_) * static_cast<double>(count));
      const Vec3 p =
          Vec3(&rest_[3 * std::min(i, count - 1)]) + soft_->edge() * Vec3(between(-.5, .5), between(-.5, .5), 0.0);
      const scene::Nearest near = soft_->nearest(p);
      if (near.point.z() > held_below_ + soft_->edge()) return near;
    }
  }

  Action draw() {
    const double kind = uniform(random_);
    Action a;
    a.hard = uniform(random_) < range_.hard_share;
    a.limit = a.hard ? range_.hard_force : between(range_.force_min, range_.force_max);
    a.speed = between(range_.speed_min, range_.speed_max);
    a.friction = between(0.0, range_.friction);
    out_.hard += a.hard ? 1 : 0;
    const scene::Nearest at = target();
    const Vec3 n = at.normal.normalized(), side = n.unitOrthogonal();
    const Vec3 along = Eigen::AngleAxisd(between(0.0, 6.28), n) * side;
    if (kind < 0.5) {
      poke(a, at.point, n, along);
    } else if (kind < 0.75) {
      slide(a, at.point, n, along);
    } else {
      grasp(a, at.point, n, along);
    }
    return a;
  }

  void poke(Action& a, const Vec3& q, const Vec3& n, const Vec3& along) {
    ++out_.pokes;
    a.held = true;
    const Vec3 in = (-n + between(0.0, 0.8) * along).normalized();
    const Vec3 first = q - 2.5 * range_.radius * in;
    a.way = {alone(first), alone(q + between(0.1, 1.0) * range_.depth * in), alone(first)};
  }

  void slide(Action& a, const Vec3& q, const Vec3& n, const Vec3& along) {
    ++out_.slides;
    a.speed = range_.speed_max;
    const Vec3 in = q + (range_.radius - between(0.1, 1.2) * range_.radius) * n, on = in + between(0.01, 0.04) * along;
    a.way = {alone(q + 3.0 * range_.radius * n), alone(in), alone(on), alone(on + 8.0 * range_.radius * n)};
  }

  /// Both spheres go in beside the point, close on each other and pull out.
  void grasp(Action& a, const Vec3& q, const Vec3& n, const Vec3& along) {
    ++out_.grasps;
    const auto at = [&](double height, double apart) {
      return Centres{q + height * n + apart * along, q + height * n - apart * along};
    };
    const double r = range_.radius, in = between(-1.0, 0.5) * r, gap = between(1.05, 1.4) * r;
    a.way = {at(3.0 * r, 2.5 * r), at(in, 2.5 * r), at(in, gap), at(in + between(0.01, 0.04), gap),
             at(in + 0.05, 4.0 * r)};
  }

  static Centres alone(const Vec3& p) { return {p, p + Vec3(kAway, kAway, kAway)}; }

  struct Flags {
    bool touched = false, bad = false, popped = false, frozen = false, hurried = false;
  };

  void perform(const Action& a) {
    Flags seen;
    scene_.objects[0].material.mu = a.friction;
    tool_.reset();
    bool out = false;
    std::vector<Centres> gone;
    for (std::size_t leg = 0; leg + 1 < a.way.size() && !out; ++leg) {
      const Centres &from = a.way[leg], &to = a.way[leg + 1];
      const double length = std::max((to[0] - from[0]).norm(), (to[1] - from[1]).norm());
      const int n = std::max(1, static_cast<int>(std::ceil(length / (a.speed * kSoftTick))));
      for (int i = 1; i <= n && !out; ++i) {
        const double s = static_cast<double>(i) / n;
        gone.push_back({from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])});
        out = tick(gone.back(), seen) > a.limit;
        if (!a.hard) out_.largest_force = std::max(out_.largest_force, force_);
      }
      if (a.held && leg == 0 && !gone.empty()) hold(a, gone.back(), seen);
    }
    for (; out && !gone.empty(); gone.pop_back()) tick(gone.back(), seen);
    pause(kSoftPause, &seen);
    count(a, seen);
  }

  /// Holds the tool where it is. In the last third of the time, the force must only creep or swing slowly, with a small
  /// second difference, or the body's swing must decay: a contact that chatters sustains it.
  void hold(const Action& a, const Centres& at, Flags& seen) {
    std::array<double, 3> jump{}, kinetic{};  // largest ones of each third
    std::array<Vec3, 2> last{total_, total_};
    const int n = static_cast<int>(range_.hold / kSoftTick);
    for (int i = 0; i < n; ++i) {
      tick(at, seen);
      const std::size_t third = to_index(3 * i / n);
      jump[third] = std::max(jump[third], (total_ - 2.0 * last[0] + last[1]).norm());
      kinetic[third] = std::max(kinetic[third], soft_->state().kinetic);
      last = {total_, last[0]};
    }
    if (n == 0 || !(force_ > 0.0)) return;
    ++out_.held;
    const bool rests = jump[2] < range_.restless || kinetic[2] < range_.decay * kinetic[1];
    out_.restless += !a.hard && !rests ? 1 : 0;
  }

  void count(const Action& a, const Flags& seen) {
    out_.touched += seen.touched ? 1 : 0;
    out_.not_finite += seen.bad ? 1 : 0;
    out_.popped += seen.popped ? 1 : 0;
    out_.hurried += seen.hurried ? 1 : 0;
    (a.hard ? out_.guarded_hard : out_.guarded) += seen.frozen ? 1 : 0;
  }

  /// One tick of contact, force and tissue; returns the largest force of a sphere [N].
  double tick(const Centres& centres, Flags& seen) {
    const ContactSet& contacts = tool_.step(scene_, centres.data(), t_);
    const force::ForceTerms terms = force::step(contacts, {}, 1.0, 1.0);
    loop::advance_soft(scene_, tool_, contacts, terms, t_, kSoftTick);
    t_ += kSoftTick;
    ++out_.ticks;
    std::array<double, 2> deflection{};
    force_ = 0.0;
    total_ = terms.F;
    for (int i = 0; i < contacts.size; ++i) {
      const Contact& c = contacts.contact[to_index(i)];
      deflection[to_index(c.sphere)] = c.delta_x.norm();
      force_ = std::max(force_, terms.F_contact[to_index(i)].f.norm());
    }
    const scene::DeformableState state = soft_->state();
    seen.touched |= contacts.size > 0;
    seen.bad |= !terms.F.allFinite() || !std::isfinite(state.potential) || !std::isfinite(state.kinetic);
    seen.frozen |= state.frozen;
    seen.hurried |= state.hurried;
    for (std::size_t s = 0; s < 2; ++s) {
      seen.popped |= deflection[s] == 0.0 && (last_[s] > kReach * range_.radius || inside(centres[s]));
    }
    last_ = deflection;
    out_.least_volume = std::min(out_.least_volume, soft_->body().least_volume());
    return force_;
  }

  [[nodiscard]] bool inside(const Vec3& p) const {
    return p.squaredNorm() < 1.0 && soft_->nearest(p).distance < -0.2 * range_.radius;
  }

  void pause(double seconds, Flags* seen) {
    Flags mine;
    for (int i = 0; i < static_cast<int>(seconds / kSoftTick); ++i) tick(tip_, seen != nullptr ? *seen : mine);
  }

  void check_rest() {
    pause(range_.rest, nullptr);
    ++out_.rests;
    const tissue::Body& body = soft_->body();
    const double volume = body.least_volume();
    double farthest = 0.0;
    for (std::size_t i = 0; i < body.node_count(); ++i) {
      farthest = std::max(farthest, body.displacement(static_cast<std::int32_t>(i)).norm());
    }
    out_.least_volume_at_rest = std::min(out_.least_volume_at_rest, volume);
    out_.inverted_at_rest += volume > 0.0 ? 0 : 1;
    out_.moved_at_rest += farthest < kMoved * soft_->edge() ? 0 : 1;
  }

  TissueSoakRange range_;
  double held_below_;
  std::mt19937_64 random_;
  std::shared_ptr<tissue::SoftSurface> soft_;
  contact::Tool tool_;
  scene::Snapshot scene_;
  std::vector<double> rest_;
  Centres tip_;
  std::array<double, 2> last_{};
  double t_ = 0.0, force_ = 0.0;  // force_: largest one of a sphere
  Vec3 total_ = Vec3::Zero();     // on all spheres
  TissueSoakReport out_;
};

}  // namespace

TissueSoakReport soak_tissue(const tissue::SoftSurface& surface, std::int64_t actions, std::uint64_t seed,
                             double held_below, const TissueSoakRange& range) {
  return TissueSoak(surface, seed, held_below, range).run(actions);
}

}  // namespace palpate::verify
