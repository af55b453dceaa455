// One soft body that several loops touch, each through a view of its own.
//
// A view is a SoftSurface whose body is not stepped: it takes the shape of the shared body, and keeps the viscous
// memory of its own tool. In every tick a loop posts its contacts and reads the newest state, both through mailboxes,
// so no loop waits for another. The body is stepped once a tick by the loop that comes first, with the newest contacts
// of all loops. Those of the others are then at most one tick old; their normal forces follow the surface meanwhile. A
// loop that stands still leaves its tool where it was, and the others go on stepping.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/tissue/soft_surface.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::tissue {

/// The body, and the mailboxes of its views.
class SharedBody {
 public:
  static constexpr int kViews = SoftSurface::kTools;
  static constexpr int kMaxLoads = 32;

  /// `surface` is copied at rest.
  explicit SharedBody(const SoftSurface& surface);

  /// Takes a place for a view. The first one puts the body to rest. It allocates memory and may wait for a step. Throws
  /// std::runtime_error if all places are taken.
  int join();
  /// Gives the place back; its contacts end.
  void leave(int view) noexcept;
  /// Posts the contacts of a view and advances the body by a tick of dt [s], unless another view has done so for this
  /// tick or is just doing it. Only the thread of the view may call it.
  void advance(int view, std::span<const scene::SurfaceLoad> loads, double dt) noexcept;
  /// Newest shape; valid until the next call. Only the thread of the view may call it.
  [[nodiscard]] const Shape& shape(int view) noexcept { return place_[static_cast<std::size_t>(view)]->out.read(); }
  /// Displacements of the nodes [m], 3 per node. It may wait for a step.
  [[nodiscard]] std::vector<double> displacements();
  /// A view of the body, at rest.
  [[nodiscard]] std::shared_ptr<SoftSurface> view() const;

 private:
  struct Loads {
    std::array<scene::SurfaceLoad, kMaxLoads> load;
    std::size_t count = 0;
  };
  struct Place {
    explicit Place(const Shape& first) : out(first) {}
    Mailbox<Loads> in;
    Mailbox<Shape> out;
    std::atomic<bool> taken{false};
    std::uint64_t ticks = 0;  ///< of this view; equal to ticks_ of the body in step
  };

  void step(double dt) noexcept;
  void publish() noexcept;

  std::shared_ptr<SoftSurface> body_;
  std::vector<std::unique_ptr<Place>> place_;  ///< kViews places
  std::atomic_flag busy_{};                    ///< guards body_ and the reading side of Place::in
  std::atomic<std::uint64_t> ticks_{0};        ///< ticks by which the body has advanced
};

/// A soft surface whose copies at rest (at_rest) are views of one body.
class SharedSurface final : public scene::Surface, public scene::Deformable {
 public:
  explicit SharedSurface(const SoftSurface& surface);
  ~SharedSurface() override;

  [[nodiscard]] scene::Nearest nearest(const Vec3& p) const noexcept override { return view_->nearest(p); }
  [[nodiscard]] scene::Nearest nearest_or_far(const Vec3& p, double exact_within) const noexcept override {
    return view_->nearest_or_far(p, exact_within);
  }
  [[nodiscard]] const scene::Mesh* mesh() const noexcept override { return view_->mesh(); }
  [[nodiscard]] Deformable* deformable() const noexcept override { return const_cast<SharedSurface*>(this); }

  [[nodiscard]] SharedBody& shared() const noexcept { return *body_; }

  [[nodiscard]] std::shared_ptr<Surface> at_rest() const override;
  [[nodiscard]] scene::Response respond(const scene::SpherePlace& at) const noexcept override {
    return view_->respond(at);
  }
  [[nodiscard]] Vec3 velocity(const Vec3& p) const noexcept override { return view_->velocity(p); }
  void advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept override;
  [[nodiscard]] scene::DeformableState state() const noexcept override { return view_->state(); }
  [[nodiscard]] std::span<const double> published() noexcept override { return view_->published(); }
  // The body steps in the cycle of the loop that comes first.
  [[nodiscard]] double period() const noexcept override { return 0.0; }
  void set_beside(bool) noexcept override {}
  bool work() noexcept override { return false; }

 private:
  SharedSurface(std::shared_ptr<SharedBody> body, std::uint64_t id);

  std::shared_ptr<SharedBody> body_;
  std::shared_ptr<SoftSurface> view_;
  int place_ = -1;  ///< -1: the surface at rest, which nobody touches
};

}  // namespace palpate::tissue
