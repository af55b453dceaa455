#include "palpate/tissue/pressed_body.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kFast = 0.05;     // [edge] displacement in a step beyond which steps are halved
constexpr double kTooFast = 0.5;   // [edge] displacement in a step that is a divergence
constexpr double kStill = 0.1;     // [s] of standing still after a divergence
constexpr double kHealthy = 0.5;   // [s] a divergence within this time after the last one returns the body to rest
constexpr double kMaxLoad = 30.0;  // [N] largest force of one contact on the body

}  // namespace

PressedBody::PressedBody(const Body& body, std::shared_ptr<const SoftTables> tables)
    : body_(body), tables_(std::move(tables)), safe_u_(3 * body.node_count(), 0.0), zero_(safe_u_) {
  for (const PronyTerm& term : body_.data().prony) instantaneous_ += term.g;
  body_.reset();
}

Shape PressedBody::at_rest() const {
  Shape out;
  out.vertices.assign(tables_->rest->vertices().begin(), tables_->rest->vertices().end());
  out.velocity.assign(out.vertices.size(), 0.0);
  return out;
}

void PressedBody::advance(const Press& press, Shape& out) noexcept {
  for (int i = 0; i < press.touches; ++i) {
    (void)meet(press.touch[to_index(i)], 0.0);
    start_[to_index(i)].setZero();
    for (int k = 0; k < press.touch[to_index(i)].patch.vertices(); ++k) {
      held_[to_index(i)][to_index(k)] = static_cast<float>(share_[to_index(k)]);
      start_[to_index(i)] += static_cast<double>(held_[to_index(i)][to_index(k)]) * x_[to_index(k)];
    }
  }
  for (int k = 0; k < press.ticks; ++k) {
    std::copy(body_.displacements().begin(), body_.displacements().end(), safe_u_.begin());
    safe_volume_ = body_.least_volume();
    if (still_ <= 0.0) step(press, k * press.dt);
    guard(press.dt);
  }
  describe(press, out);
}

void PressedBody::step(const Press& press, double since) noexcept {
  const int halves = hurried_ ? 2 : 1;
  const int steps = halves * std::max(1, static_cast<int>(std::lround(press.dt / body_.time_step())));
  for (int i = 0; i < steps; ++i) {
    push(press, since + i * press.dt / steps);
    body_.step(halves);
  }
}

/// Meets the surface as it is with the tool, which is taken to go on at its velocity. It sets x_, pull_ and share_.
Meeting PressedBody::meet(const Touch& touch, double since) noexcept {
  for (int k = 0; k < touch.patch.vertices(); ++k)
    x_[to_index(k)] = position_of(*tables_, touch.patch.vertex(k), body_.displacements());
  return touch.patch.meet(*tables_, touch.centre + since * touch.velocity, x_.data(), pull_.data(), share_.data());
}

/// Motion of the vertices that held the contact when the press began, after meet().
Vec3 PressedBody::moved(int touch, int vertices) const noexcept {
  Vec3 out = -start_[to_index(touch)];
  for (std::size_t k = 0; k < to_index(vertices); ++k) out += static_cast<double>(held_[to_index(touch)][k]) * x_[k];
  return out;
}

void PressedBody::push(const Press& press, double since) noexcept {
  body_.clear_loads();
  for (int i = 0; i < press.touches; ++i) {
    const Touch& touch = press.touch[to_index(i)];
    const Meeting met = meet(touch, since);
    const double elastic = touch.law.at(met.depth).force;
    const double normal_force = std::max(instantaneous_ * elastic + touch.viscous, 0.0);
    Vec3 along = moved(i, touch.patch.vertices());
    along -= touch.normal.dot(along) * touch.normal;
    const Vec3 friction = touch.force + touch.secant * along;
    const double size = (normal_force * met.push + friction).norm();
    if (!(size > 0.0) || !std::isfinite(size)) continue;
    const double scale = -press.share * std::min(1.0, kMaxLoad / size);
    for (int k = 0; k < touch.patch.vertices(); ++k) {
      const Vec3 force = scale * (normal_force * pull_[to_index(k)] + share_[to_index(k)] * friction);
      const std::size_t vertex = to_index(touch.patch.vertex(k));
      for (std::size_t e = tables_->first[vertex]; e < tables_->first[vertex + 1]; ++e)
        body_.add_load(tables_->weights[e].node, static_cast<double>(tables_->weights[e].weight) * force);
    }
  }
}

/// Answers fast motion with shorter steps, and a divergence with a return to the last displacements, at rest; to the
/// undeformed shape if a tetrahedron is inverted there, or if they lead to another divergence.
void PressedBody::guard(double dt) noexcept {
  healthy_ += dt;
  const double fastest = still_ > 0.0 ? 0.0 : body_.fastest();
  if (!(fastest <= kTooFast * tables_->edge)) {
    const bool finite = std::all_of(safe_u_.begin(), safe_u_.end(), [](double u) { return std::isfinite(u); });
    body_.reset();
    if (finite && safe_volume_ > 0.0 && healthy_ >= kHealthy) body_.set_state(safe_u_, zero_);
    still_ = kStill;
    healthy_ = -kStill;
    hurried_ = true;
    return;
  }
  still_ = std::max(still_ - dt, 0.0);
  hurried_ = healthy_ < kHealthy || fastest > (hurried_ ? 0.25 : 1.0) * kFast * tables_->edge;
}

// In single precision, which rounds the places by less than a millionth of a millimetre.
void PressedBody::describe_surface(Shape& out) const noexcept {
  using Row = Eigen::Map<const Eigen::Vector4f, Eigen::Aligned16>;
  const std::span<const Body::Four> u = body_.displacements32(), v = body_.velocities32();
  for (std::size_t i = 0; i < tables_->node.size(); ++i) {
    Eigen::Vector4f moved = Eigen::Vector4f::Zero(), rate = moved;
    for (std::size_t k = tables_->first[i]; k < tables_->first[i + 1]; ++k) {
      const SoftTables::NodeWeight& e = tables_->weights[k];
      moved += e.weight * Row(u[to_index(e.node)].x);
      rate += e.weight * Row(v[to_index(e.node)].x);
    }
    const Vec3 rest(&body_.data().nodes[3 * to_index(tables_->node[i])]);
    Eigen::Map<Vec3>(&out.vertices[3 * i]) = rest + moved.head<3>().cast<double>();
    Eigen::Map<Vec3>(&out.velocity[3 * i]) = rate.head<3>().cast<double>();
  }
}

void PressedBody::describe(const Press& press, Shape& out) noexcept {
  out.number = press.number;
  describe_surface(out);
  out.energy = body_.energy();
  out.hurried = hurried_;
  out.still = still_ > 0.0;
  out.touches = press.touches;
  for (int i = 0; i < press.touches; ++i) {
    const Touch& touch = press.touch[to_index(i)];
    const LocalLaw::Value end = touch.law.at(meet(touch, press.ticks * press.dt).depth);
    out.yield[to_index(i)] = {touch.sphere, end.yield, end.kept, moved(i, touch.patch.vertices())};
  }
}

}  // namespace palpate::tissue
