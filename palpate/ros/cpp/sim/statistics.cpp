#include "sim/statistics.hpp"

#include <algorithm>
#include <cctype>
#include <cisst_msgs/msg/interval_statistics.hpp>

#include "convert.hpp"
#include "rcl/publisher.hpp"

namespace palpate::ros {
namespace {

constexpr std::int64_t kStatisticsPeriod = 200'000'000;  // [ns]

std::string lower(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

}  // namespace

struct Statistics::TopicPublisher {
  TopicPublisher(Node& node, const std::string& topic, IntervalMeter& of) : publisher(node, topic), meter(&of) {}
  Publisher<cisst_msgs::msg::IntervalStatistics> publisher;
  IntervalMeter* meter;
  cisst_msgs::msg::IntervalStatistics message;
};

Statistics::Statistics(Node& node, const dvrk::System& robot) : node_(node) {
  add("publishers", publish);
  add("stats/subscribers", commands);
  add("stats/events", publish);
  for (const std::string& arm : robot.arms()) {
    add("stats/" + lower(arm) + "_arm", servo);
    add("stats/publishers_" + lower(arm) + "_arm", publish);
  }
  for (const std::string& teleop : robot.teleops()) add("stats/" + lower(teleop) + "_setting", servo);
}
Statistics::~Statistics() = default;

void Statistics::add(const std::string& name, IntervalMeter& meter) {
  publishers_.push_back(std::make_unique<TopicPublisher>(node_, name + "/period_statistics", meter));
}

void Statistics::send(std::int64_t now, std::int64_t time_ns) {
  if (now - sent_ < kStatisticsPeriod) return;
  sent_ = now;
  for (const auto& to : publishers_) {
    if (to->publisher.listeners() == 0) continue;
    const Interval& of = to->meter->read();
    auto& m = to->message;
    m.header.stamp = stamp(of.period.n > 0 ? time_ns : 0);
    m.period_avg = of.period.mean, m.period_std_dev = of.period.deviation();
    m.period_min = of.period.least, m.period_max = of.period.most;
    m.compute_time_avg = of.compute.mean, m.compute_time_std_dev = of.compute.deviation();
    m.compute_time_min = of.compute.least, m.compute_time_max = of.compute.most;
    m.number_of_samples = of.period.n;
    m.number_of_overruns = of.overruns;
    m.statistics_interval = IntervalMeter::kWindow;
    if (const Status sent = to->publisher.publish(m); !sent) node_.problem(sent.problem);
  }
}

}  // namespace palpate::ros
