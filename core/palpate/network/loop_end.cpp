#include "palpate/network/loop_end.hpp"

#include <algorithm>
#include <utility>

#include "palpate/loop/realtime.hpp"

namespace palpate::network {
namespace {

LinkState first(std::size_t objects) {
  LinkState out;
  out.models.resize(objects);
  return out;
}

}  // namespace

LoopEnd::LoopEnd(const LoopEndOptions& options, scene::Snapshot scene)
    : options_(options),
      model_(options.update, std::move(scene), options.planes),
      state_(first(model_.updates().size())),
      now_(first(model_.updates().size())) {}

LinkState LoopEnd::state() {
  const std::lock_guard lock(readers_);
  return state_.read();
}

const loop::RemoteTick& LoopEnd::step(const loop::LocalTool& tool) noexcept {
  return step_at(tool, 1e-9 * static_cast<double>(loop::now_ns()));
}

const loop::RemoteTick& LoopEnd::step_at(const loop::LocalTool& tool, double now) noexcept {
  const double dt = t_ < 0.0 ? 0.0 : std::max(tool.t - t_, 0.0);
  if (t_ < 0.0) p_ = tool.X.p;
  if (dt > 0.0) v_ = (tool.X.p - p_) / dt;
  p_ = tool.X.p;
  t_ = tool.t;
  for (Arrived a; inbox_.pop(a); now_.received += 1.0) {
    if (peer_.receive(a.d, a.at)) model_.take(a.d.model);
  }
  peer_.step(now);
  link();
  if (now_.received > 0.0 && !out_.linked) now_.held += dt;
  const Vec3 rendered = options_.mode == Mode::model ? tool.F : out_.F;
  port_.step(rendered, tool.X.p);
  feel(tool, now, dt);
  publish(tool, now);
  return out_;
}

void LoopEnd::link() noexcept {
  const bool aligned = peer_.known() && (peer_.newest().flags & kAligned) != 0;
  out_.linked = peer_.known() && !peer_.lost() && (out_.linked || aligned);
}

// Moving objects stand where they will be when the motion of this tick is executed at the site.
void LoopEnd::feel(const loop::LocalTool& tool, double now, double dt) noexcept {
  if (options_.mode != Mode::model) {
    out_.scene = &empty_;
    const Vec3 F = out_.linked ? peer_.newest().F : Vec3(Vec3::Zero());
    out_.F = F;
    if (options_.mode == Mode::passivity && out_.linked) {
      out_.F = port_.affordable(F, v_, peer_.newest().energy_in, dt) - options_.drag * v_;
    }
    return;
  }
  model_.synchronise(peer_.peer_time(now) + peer_.newest().play_delay - tool.t);
  model_.step(tool.X.p, v_, tool.F, options_.radius, tool.t, dt);
  out_.scene = &model_.scene();
}

void LoopEnd::publish(const loop::LocalTool& tool, double now) noexcept {
  Datagram& d = now_.out;
  d.X = tool.X;
  d.v = v_;
  d.jaw = tool.jaw;
  d.F = options_.mode == Mode::model ? tool.F : out_.F;
  d.energy_in = port_.in();
  d.energy_out = port_.out();
  d.flags = kEngaged;
  peer_.stamp(d, now);
  static_cast<Ages&>(now_) = peer_.arrivals().ages();
  now_.newest = peer_.newest();
  now_.offset = peer_.clock().offset(now);
  now_.drift = peer_.clock().drift();
  now_.bound = peer_.clock().bound();
  now_.known = peer_.clock().known();
  now_.linked = out_.linked;
  now_.outage = peer_.outage();
  now_.tank = options_.update.capacity;
  now_.paid = 0.0;
  for (std::size_t i = 0; i < now_.models.size(); ++i) {
    const ModelUpdate& update = model_.updates()[i];
    now_.models[i] = model_.rendered(i);
    now_.tank = std::min(now_.tank, update.tank());
    now_.paid += update.paid();
  }
  state_.write(now_);
  const Datagram& remote = now_.newest;
  out_.p_tool = remote.X.p;
  out_.F_tool = remote.F;
  out_.age = now_.age;
  out_.delay = remote.play_delay;
  out_.received = now_.received;
  out_.paid = now_.paid;
  out_.tank = options_.mode == Mode::model ? now_.tank : 0.0;
}

}  // namespace palpate::network
