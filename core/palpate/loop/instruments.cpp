#include "palpate/loop/instruments.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpate/loop/record.hpp"
#include "palpate/types/index.hpp"

namespace palpate::loop {
namespace {

constexpr int kSilent = 5;  // ticks without news after which another instrument counts as at rest

}  // namespace

void Board::write(int writer, const Published& published) noexcept {
  for (int reader = 0; reader < size_; ++reader) {
    if (reader != writer) boxes_[box(writer, reader)].write(published);
  }
}

void OnTool::add(const BodyContact& bodies) noexcept {
  F_T_W = F_T_W + bodies.F_T_W;
  stiffness += bodies.stiffness;
  F_held_W = bodies.F_held_W;
  holding = bodies.holds >= 0 ? Holding::carries : Holding::none;
  if (bodies.holds >= 0) X_WO = bodies.X_WO;
}

void OnTool::record(Tick& tick) const noexcept {
  copy(F_T_W.f, tick.F_instrument_W);
  copy(F_T_W.t, tick.t_instrument_W);
  tick.instrument_gap = gap;
  tick.handle_gap = handle_gap;
  copy(F_held_W, tick.F_held_W);
  tick.holding = static_cast<double>(holding);
  copy(X_WO.p, tick.p_WO);
  copy(X_WO.R, tick.quat_WO);
}

InWorld::InWorld(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules, contact::InstrumentLaw law,
                 int links)
    : board_(std::move(board)), index_(index), capsules_(std::move(capsules)), law_(law), rod_(board_->rod()) {
  if (board_->size() > kMaxInstruments || index < 0 || index >= board_->size()) {
    throw std::invalid_argument("instruments: " + std::to_string(board_->size()) + " in one world; at most " +
                                std::to_string(kMaxInstruments) + " are possible");
  }
  if (capsules_.empty() || capsules_.size() > to_index(contact::kMaxCapsules)) {
    throw std::invalid_argument("instruments: " + std::to_string(capsules_.size()) +
                                " capsules; an instrument has 1 to " + std::to_string(contact::kMaxCapsules));
  }
  for (const ToolCapsule& capsule : capsules_) {
    if (std::max(capsule.a.link, capsule.b.link) >= links) {
      throw std::invalid_argument("instruments: a capsule sits on a link that the follower does not have");
    }
  }
  if (!(law.stiffness >= 0.0 && std::isfinite(law.stiffness)) || !(law.damping >= 0.0 && std::isfinite(law.damping))) {
    throw std::invalid_argument("instruments: stiffness and damping must be finite and at least 0");
  }
}

void InWorld::publish(const InstrumentState& at) noexcept {
  p_WT_ = at.X_WT.p;
  own_.p_WH = at.p_WH;
  const bool moving = own_.size > 0 && at.rate > 0.0;
  const auto place = [&](const contact::ToolSphere& s) -> Vec3 {
    const Vec3 p = s.centre(at.jaw);
    return s.link < 0 ? at.X_WT * p : at.X_WA * (at.follower->link_pose(s.link) * p);
  };
  const auto move = [&](const Vec3& to, Vec3& from, Vec3& v) {
    const Vec3 now = moving ? Vec3((to - from) * at.rate) : Vec3::Zero();
    v = at.share < 1.0 ? Vec3(v + at.share * (now - v)) : now;
    from = to;
  };
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    contact::Capsule& c = own_.capsule[i];
    move(place(capsules_[i].a), c.a, c.v_a);
    move(place(capsules_[i].b), c.b, c.v_b);
    c.radius = capsules_[i].radius;
  }
  own_.size = static_cast<int>(capsules_.size());
  ++own_.sequence;
  if (board_->rod().radius > 0.0) hold(at.X_WT);
  board_->write(index_, published_);
}

// Lets the jaws hold the rod. A jaw is a capsule that turns on a hinge; its side is the sense in which it opens.
void InWorld::hold(const Pose& X_WT) noexcept {
  std::array<Jaw, contact::kMaxCapsules> jaws;
  std::size_t n = 0;
  const Vec3* opens = nullptr;
  for (std::size_t i = 0; i < capsules_.size(); ++i) {
    const Vec3& axis = capsules_[i].b.axis;
    if (axis.isZero(0.0)) continue;
    if (opens == nullptr) opens = &axis;
    jaws[n++] = {own_.capsule[i], axis.dot(*opens) > 0.0 ? 0 : 1};
  }
  rod_.step(X_WT, {jaws.data(), n}, other_grips(), board_->order());
  published_.grip = rod_.grip();
}

std::span<const Grip> InWorld::other_grips() noexcept {
  std::size_t others = 0;
  for (int k = 0; k < board_->size(); ++k) {
    if (k != index_) grips_[others++] = board_->read(k, index_).grip;
  }
  return {grips_.data(), others};
}

// The newest state of another instrument. One that is no longer published stands where it was.
const contact::Instrument& InWorld::seen(int other) noexcept {
  const std::size_t k = to_index(other);
  const contact::Instrument& newest = board_->read(other, index_).instrument;
  if (newest.sequence != other_[k].sequence) {
    other_[k] = newest;
    silent_[k] = 0;
  } else if (++silent_[k] == kSilent) {
    for (contact::Capsule& c : other_[k].capsule) c.v_a = c.v_b = Vec3::Zero();
  }
  return other_[k];
}

const OnTool& InWorld::step() noexcept {
  out_ = OnTool{};
  for (int k = 0; k < board_->size() && own_.size > 0; ++k) {
    if (k == index_) continue;
    const contact::Instrument& other = seen(k);
    if (other.size == 0) continue;
    out_.handle_gap = std::min(out_.handle_gap, (own_.p_WH - other.p_WH).norm());
    // Both loops evaluate the pair in the same order, so that their forces are opposite bit by bit.
    const bool first = index_ < k;
    double gap = 0.0;
    const int found = pair_[to_index(k)].step(first ? own_ : other, first ? other : own_, law_, pushes_, gap);
    out_.gap = std::min(out_.gap, gap);
    for (int i = 0; i < found; ++i) {
      const contact::Push& push = pushes_[to_index(i)];
      const Vec3 F = first ? push.F_A_W : Vec3(-push.F_A_W);
      out_.F_T_W.f += F;
      out_.F_T_W.t += (push.p_WC - p_WT_).cross(F);
      out_.stiffness += law_.stiffness;
      out_.power += F.dot(first ? push.v_B_W : push.v_A_W);
    }
  }
  if (board_->rod().radius > 0.0) rod_.pull(other_grips());
  out_.holding = rod_.holding();
  out_.X_WO = rod_.X_WO();
  out_.F_held_W = rod_.F_W().f;
  out_.F_T_W.f += rod_.F_W().f;
  out_.F_T_W.t += rod_.F_W().t - p_WT_.cross(rod_.F_W().f);
  out_.stiffness += rod_.stiffness();
  return out_;
}

}  // namespace palpate::loop
