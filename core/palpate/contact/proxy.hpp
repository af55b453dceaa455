// Method `proxy` (the default): a sphere that stays outside the object while the tool goes in. There is one proxy per
// object (object_proxy.hpp for meshes, field_proxy.hpp for all other surfaces), in the frame of the object, which may
// move.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/contact/broad_phase.hpp"
#include "palpate/contact/contact.hpp"
#include "palpate/contact/field_proxy.hpp"
#include "palpate/contact/object_proxy.hpp"

namespace palpate::contact {

/// Contact method with one proxy per object; see the top of this file.
class Proxy final : public Method {
 public:
  explicit Proxy(const Options& options)
      : options_(options), state_(static_cast<std::size_t>(options.objects)), near_(options.objects) {}
  void reset() noexcept override;
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;
  void record_path(std::vector<Vec3>* path) override;
  [[nodiscard]] bool has_friction() const noexcept override { return true; }
  /// Refuses objects whose regions would pull the tool in.
  void check(const scene::Snapshot& scene) const override;

 private:
  /// State of the proxy of one object.
  struct ProxyState {
    ObjectProxy proxy;  // used for a mesh
    FieldProxy field;   // used for any other surface
    Pose X_WO;          // of the object in its last tick
    std::uint64_t tick = 0;
  };

  [[nodiscard]] ObjectProxy::ProxyContact on_soft(const scene::Deformable& soft, const ObjectProxy::ProxyContact& touch,
                                                  const Vec3& p_OT) const noexcept;
  double touch(const scene::Object& object, int index, const Pose& X_WO, const Vec3& p_WT) noexcept;

  Options options_;
  std::vector<ProxyState> state_;
  BroadPhase near_;
  std::uint64_t tick_ = 1;  // number of this step
  int object_count_ = 0;    // number of objects in the previous step
  ContactSet set_;
};

}  // namespace palpate::contact
