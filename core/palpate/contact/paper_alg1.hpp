// Method `paper-alg1`: the paper's Algorithm 1 on Coal contacts, for comparison (READINGS 8, section 3.1).
//
// Two rates, as the authors' nodes had: collide() does lines 2-5 at Options::collision_rate, step() lines 5-8 at the
// rate of the cycle with the newest tool position. Between them lies one collision period: step() posts the tool's
// position at each collision instant k / collision_rate and shows from then on what was posted at the instant before.
// In lockstep this is a function of the path alone; in real time an answer that is late is shown an instant later.
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "palpate/contact/algorithm1.hpp"
#include "palpate/contact/contact.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::contact {

class PaperAlg1 final : public Method {
 public:
  explicit PaperAlg1(const Options& options);

  void reset() noexcept override;
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;
  [[nodiscard]] bool asynchronous() const noexcept override { return true; }
  void collide(const scene::Snapshot& scene) override;

 private:
  struct Request {
    Vec3 p_WT = Vec3::Zero();
    std::uint64_t number = 0;  ///< 0: nothing asked yet
    std::uint64_t epoch = 0;   ///< counts reset(): what was asked before it is not shown after it
  };
  struct Found {
    int object = -1;
    std::uint64_t mesh = 0;  ///< its id: an answer about a scene that was swapped away is not shown
    algorithm1::Plane plane;
  };
  struct Answer {
    std::array<Found, kMaxContacts> found;
    int size = 0;
    std::uint64_t epoch = 0;
  };

  // The cycle's side.
  double rate_;
  double instant_ = -1.0;  // collision instants since t = 0; below zero: none yet
  Request request_;
  Answer shown_;
  ContactSet set_;
  Mailbox<Request> requests_;
  Mailbox<Answer> answers_;

  // The side of collide().
  CoalSurface surface_;
  std::map<std::uint64_t, Vec3> n_last_;  // by mesh id
  std::uint64_t answered_ = 0, epoch_ = 0;
};

}  // namespace palpate::contact
