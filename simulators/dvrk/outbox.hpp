// The queue of outgoing events: servo periods fill it, a client empties it.
#pragma once

#include <cstddef>
#include <vector>

#include "dvrk/messages.hpp"

namespace palpate::dvrk {

/// A ring buffer of events.
class Outbox {
 public:
  /// Appends an event; drops and counts it if the queue is full.
  void send(const Event& event) noexcept {
    if (size_ == events_.size()) {
      ++dropped_;
      return;
    }
    events_[(head_ + size_++) % events_.size()] = event;
  }
  /// Takes the oldest event. Returns false if the queue is empty.
  bool next(Event& event) noexcept {
    if (size_ == 0) return false;
    event = events_[head_];
    head_ = (head_ + 1) % events_.size();
    --size_;
    return true;
  }
  /// Number of dropped events.
  [[nodiscard]] std::size_t dropped() const noexcept { return dropped_; }

 private:
  std::vector<Event> events_ = std::vector<Event>(2048);
  std::size_t head_ = 0, size_ = 0, dropped_ = 0;
};

/// Publisher of a component: sends its events to the outbox.
class EventPublisher {
 public:
  EventPublisher(Address from, Text name, Outbox& out) : from_(from), name_(name), out_(&out) {}

  /// Sets the time of the following events [s].
  void at(double t) noexcept { t_ = t; }
  [[nodiscard]] double t() const noexcept { return t_; }
  [[nodiscard]] const Text& name() const noexcept { return name_; }

  // One function per payload; say() is for events without a payload.
  void publish(Topic topic) const noexcept { out_->send(event(topic)); }
  void flag(Topic topic, bool flag) const noexcept {
    Event e = event(topic);
    e.flag = flag;
    out_->send(e);
  }
  void value(Topic topic, double value) const noexcept {
    Event e = event(topic);
    e.value = value;
    out_->send(e);
  }
  void button(Topic topic, int button) const noexcept {
    Event e = event(topic);
    e.button = button;
    out_->send(e);
  }
  void text(Topic topic, const Text& text) const noexcept {
    Event e = event(topic);
    e.text = text;
    out_->send(e);
  }
  void operating(const OperatingState& state) const noexcept {
    Event e = event(Topic::operating_state);
    e.operating_state = state;
    out_->send(e);
  }
  /// A text of status, warning or error, sent as "NAME: words".
  void message(Topic topic, const Text& words) const noexcept {
    Text text = name_;
    text << ": " << words.view();
    this->text(topic, text);
  }

 private:
  [[nodiscard]] Event event(Topic topic) const noexcept {
    Event e;
    e.from = from_;
    e.topic = topic;
    e.t = t_;
    return e;
  }

  Address from_;
  Text name_;
  Outbox* out_;
  double t_ = 0.0;
};

}  // namespace palpate::dvrk
