#include "palpate/tissue/shared_surface.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
SharedBody::SharedBody(const SoftSurface& surface) : body_(surface.in_cycle()) {
  for (int i = 0; i < kViews; ++i) place_.push_back(std::make_unique<Place>(body_->shape()));
}

std::shared_ptr<SoftSurface> SharedBody::view() const { return body_->in_cycle(); }

std::vector<double> SharedBody::displacements() {
  while (busy_.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
  const std::span<const double> u = body_->body().displacements();
  std::vector<double> out(u.begin(), u.end());
  busy_.clear(std::memory_order_release);
  return out;
}

int SharedBody::join() {
  while (busy_.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
  const auto taken = [](const std::unique_ptr<Place>& place) { return place->taken.load(); };
  const auto free = std::find_if_not(place_.begin(), place_.end(), taken);
  const bool first = std::none_of(place_.begin(), place_.end(), taken);
  if (free != place_.end()) {
    if (first) body_ = body_->in_cycle();
    (*free)->ticks = ticks_.load();
    (*free)->out.write(body_->shape());
    (*free)->taken = true;
  }
  busy_.clear(std::memory_order_release);
  if (free == place_.end())
    throw std::runtime_error("tissue: at most " + std::to_string(kViews) + " pairs can touch one soft body");
  return static_cast<int>(free - place_.begin());
}

void SharedBody::leave(int view) noexcept {
  Place& place = *place_[to_index(view)];
  place.in.write(Loads{});
  place.taken = false;
}

void SharedBody::advance(int view, std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  Place& place = *place_[to_index(view)];
  Loads posted;
  posted.count = std::min(loads.size(), posted.load.size());
  std::copy_n(loads.begin(), posted.count, posted.load.begin());
  for (std::size_t i = 0; i < posted.count; ++i) {
    posted.load[i].at.sphere = view * SoftSurface::kSpheresOfTool + posted.load[i].at.sphere;
  }
  place.in.write(posted);
  ++place.ticks;
  if (place.ticks <= ticks_.load(std::memory_order_acquire)) return;
  if (busy_.test_and_set(std::memory_order_acquire)) return;
  step(dt);
  busy_.clear(std::memory_order_release);
}

// Steps the body under the newest contacts of all views; the flag busy_ is set.
void SharedBody::step(double dt) noexcept {
  std::array<scene::SurfaceLoad, kMaxTouches> all;
  std::size_t count = 0;
  for (const auto& place : place_) {
    const Loads& loads = place->in.read();
    for (std::size_t i = 0; i < loads.count && count < all.size(); ++i) all[count++] = loads.load[i];
  }
  body_->advance({all.data(), count}, dt);
  publish();
  ticks_.fetch_add(1, std::memory_order_release);
}

void SharedBody::publish() noexcept {
  for (const auto& place : place_) {
    if (place->taken.load(std::memory_order_relaxed)) place->out.write(body_->shape());
  }
}

SharedSurface::SharedSurface(const SoftSurface& surface)
    : Surface(surface.id()), body_(std::make_shared<SharedBody>(surface)), view_(body_->view()) {}

SharedSurface::SharedSurface(std::shared_ptr<SharedBody> body, std::uint64_t id)
    : Surface(id), body_(std::move(body)), view_(body_->view()), place_(body_->join()) {}

SharedSurface::~SharedSurface() {
  if (place_ >= 0) body_->leave(place_);
}

std::shared_ptr<scene::Surface> SharedSurface::at_rest() const {
  return std::shared_ptr<SharedSurface>(new SharedSurface(body_, id()));
}

void SharedSurface::advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  if (place_ < 0) return;
  view_->remember(loads, dt);
  body_->advance(place_, loads, dt);
  view_->follow(body_->shape(place_), dt);
}

}  // namespace palpate::tissue
