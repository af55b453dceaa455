// An emulated network link in the caller's time: the same code delays packets of a study in virtual time and those of a
// relay between real processes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace palpate::network {

/// Loss by the model of Gilbert and Elliott: a Markov chain of two states, stepped at each packet.
struct GilbertElliott {
  double to_bad = 0.0;     ///< probability of the step from good to bad [-]
  double to_good = 1.0;    ///< probability of the step from bad to good [-]
  double loss_good = 0.0;  ///< loss in the good state [-]
  double loss_bad = 0.0;   ///< loss in the bad state [-]
};

/// Loss by a Markov chain of four states (Salsano, Ludovici, Ordine and Giannuzzi 2012): 1 received, 2 received within
/// a burst, 3 lost within a burst, 4 lost alone. Names as in that report: p13 is the probability of the step 1 to 3.
struct FourStates {
  double p13 = 0.0, p31 = 1.0, p32 = 0.0, p23 = 1.0, p14 = 0.0;
};

/// A time without any packet.
struct Outage {
  double begin = 0.0;     ///< [s]
  double duration = 0.0;  ///< [s]
};

/// One entry of a measured trace: the delay of packets sent from this time on.
struct TracePoint {
  double t = 0.0;      ///< [s]
  double delay = 0.0;  ///< [s]; negative: such packets are lost
};

/// What the link does to packets of one direction.
struct Condition {
  double delay = 0.0;                  ///< smallest delay [s]
  std::vector<double> weights, rates;  ///< additional delay: a mixture of exponentials, weights [-] and rates [1/s]
  double correlation = 0.0;            ///< of the additional delays of successive packets, in -1..1 (see Link) [-]
  bool keep_order = false;             ///< true: no packet arrives before an earlier one
  double reorder = 0.0;                ///< share of packets that are held back by reorder_delay [-]
  double reorder_delay = 0.0;          ///< [s]
  double duplicate = 0.0;              ///< share of packets that arrive twice, each copy with its own delay [-]
  GilbertElliott gilbert;
  FourStates four;
  double rate = 0.0;                          ///< bytes per second; 0: unlimited
  double queue = 0.1;                         ///< longest wait for the rate limit, beyond which packets are lost [s]
  double outage_every = 0.0;                  ///< mean time between random outages; 0: none [s]
  double outage_min = 0.0, outage_max = 0.0;  ///< their duration is uniform between these [s]
  std::vector<Outage> outages;                ///< outages at fixed times
  std::vector<TracePoint> trace;  ///< measured delays; repeated from its end on. It replaces delay and mixture
};

/// Throws std::invalid_argument that names the value, unless the condition is valid.
void check(const Condition& condition);

/// When the copies of a packet arrive; 0 copies: it is lost.
struct Fate {
  int copies = 0;
  std::array<double, 2> arrival{};  ///< [s]
};

/// One direction of a link. Additional delays have the marginal distribution of the mixture. Their dependence is a
/// Gaussian copula: z_k = c z_k-1 + sqrt(1 - c^2) n_k is standard normal, and the delay is the quantile of the mixture
/// at Phi(z_k).
class Link {
 public:
  /// Throws std::invalid_argument as check() does.
  Link(const Condition& condition, std::uint64_t seed);
  /// Sends a packet of `bytes` at the time t [s]; times must not decrease.
  Fate send(double t, std::size_t bytes) noexcept;

 private:
  double extra() noexcept;
  bool lost_by_chain() noexcept;
  bool in_outage(double t) noexcept;
  double base(double t, bool& lost) const noexcept;
  double arrival(double t, double sent, bool& lost) noexcept;

  Condition c_;
  std::mt19937_64 random_;
  double z_ = 0.0, last_ = 0.0, free_at_ = 0.0;  ///< state of the copula; last arrival; end of the sending queue [s]
  double next_outage_ = 0.0, outage_end_ = -1.0;
  bool bad_ = false;
  int state_ = 1;  ///< of the four
};

/// Quantile of the mixture of exponentials: the x at which sum of weight exp(-rate x) = survival, in (0, 1] [s].
[[nodiscard]] double mixture_quantile(const Condition& condition, double survival) noexcept;

}  // namespace palpate::network
