// SPDX-License-Identifier: Apache-2.0
// Watches a vehicle from C++, and holds it where the dose rate is above a limit.
//
//   ros2 run rocsafe_example_cpp watch_vehicle --ros-args -r __ns:=/rav1 -p limit_usvh:=50.0
//
// It ends with 0 when the vehicle has obeyed, and with 1 when it has not. Names are relative: the
// namespace is the vehicle. `hold` needs no control lease; orders that do carry it, see Lease.srv.
#include <chrono>
#include <cstdlib>
#include <memory>

#include <rclcpp/rclcpp.hpp>
#include <rocsafe_interfaces/msg/radiation_reading.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <std_srvs/srv/trigger.hpp>

using rocsafe_interfaces::msg::RadiationReading;
using sensor_msgs::msg::NavSatFix;
using std_srvs::srv::Trigger;

constexpr std::chrono::seconds ANSWER_WITHIN{5};

class WatchVehicle : public rclcpp::Node
{
public:
  WatchVehicle()
  : Node("watch_vehicle"), limit_usvh_(declare_parameter("limit_usvh", 50.0))
  {
    // As the vehicle publishes them: reliable. Older messages than ours are not wanted.
    const auto qos = rclcpp::QoS(50).reliable();
    fixes_ = create_subscription<NavSatFix>(
      "fix", qos, [this](NavSatFix::ConstSharedPtr fix) {
        RCLCPP_INFO_THROTTLE(
          get_logger(), *get_clock(), 1000, "at %.6f %.6f, %.1f m above the ellipsoid",
          fix->latitude, fix->longitude, fix->altitude);
      });
    readings_ = create_subscription<RadiationReading>(
      "radiation", qos, [this](RadiationReading::ConstSharedPtr reading) {on_reading(*reading);});
    hold_ = create_client<Trigger>("hold");
  }

  bool has_obeyed() const {return has_obeyed_;}

private:
  void on_reading(const RadiationReading & reading)
  {
    // A saturated detector tells a lower limit only: it is above any limit that we could check.
    const bool is_high = reading.saturated || reading.dose_rate_usvh > limit_usvh_;
    if (!is_high || is_sent_) {
      return;
    }
    RCLCPP_INFO(get_logger(), "%.1f uSv/h: hold", reading.dose_rate_usvh);
    if (!hold_->service_is_ready()) {
      RCLCPP_WARN(get_logger(), "no vehicle serves hold yet");
      return;
    }
    is_sent_ = true;
    deadline_ = create_wall_timer(
      ANSWER_WITHIN, [this] {
        RCLCPP_ERROR(get_logger(), "no answer to hold within 5 s");
        rclcpp::shutdown();
      });
    hold_->async_send_request(
      std::make_shared<Trigger::Request>(),
      [this](rclcpp::Client<Trigger>::SharedFuture answer) {
        has_obeyed_ = answer.get()->success;
        RCLCPP_INFO(
          get_logger(), "%s: %s", has_obeyed_ ? "holds" : "refused",
          answer.get()->message.c_str());
        rclcpp::shutdown();
      });
  }

  double limit_usvh_;
  bool is_sent_ = false;
  bool has_obeyed_ = false;
  rclcpp::Subscription<NavSatFix>::SharedPtr fixes_;
  rclcpp::Subscription<RadiationReading>::SharedPtr readings_;
  rclcpp::Client<Trigger>::SharedPtr hold_;
  rclcpp::TimerBase::SharedPtr deadline_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<WatchVehicle>();
  rclcpp::spin(node);
  return node->has_obeyed() ? EXIT_SUCCESS : EXIT_FAILURE;
}
