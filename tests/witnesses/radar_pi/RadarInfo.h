// What the receiver and the control of radar_pi for a Garmin xHD take of the rest of the plug-in: it tells what they say, one
// line each, to standard output. A list made when it is built has the names of its controls.
#pragma once
#include "pi_common.h"
#include "socketutil.h"
#include <chrono>
#include <string>
namespace RadarPlugin {
inline double Now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }
inline void Say(const std::string &what, long value) { printf("%.4f %s %ld\n", Now(), what.c_str(), value), fflush(stdout); }
#define LOG_NOTHING(...) do {} while (0)
#define LOG_INFO LOG_NOTHING
#define LOG_VERBOSE LOG_NOTHING
#define LOG_RECEIVE LOG_NOTHING
#define LOG_TRANSMIT LOG_NOTHING
#define LOG_BINARY_RECEIVE LOG_NOTHING
#define LOG_BINARY_REPORTS LOG_NOTHING
#define IF_LOG_AT(...) LOG_NOTHING()
#define WATCHDOG_TIMEOUT 10
#define DATA_TIMEOUT 5
#define GARMIN_XHD_SPOKES 1440
#define GARMIN_XHD_MAX_SPOKE_LEN 705
#define MOD_SPOKES(raw) (((raw) + 2 * GARMIN_XHD_SPOKES) % GARMIN_XHD_SPOKES)
#define MAX(a, b) ((a) > (b) ? (a) : (b))
typedef int SpokeBearing;
enum RadarState { RADAR_OFF, RADAR_STANDBY, RADAR_WARMING_UP, RADAR_TIMED_IDLE, RADAR_STOPPING, RADAR_SPINNING_DOWN, RADAR_STARTING,
                  RADAR_SPINNING_UP, RADAR_TRANSMIT };
enum RadarControlState { RCS_OFF = -1, RCS_MANUAL, RCS_AUTO_1, RCS_AUTO_2 };
enum ControlType {
#include "items.h"
};
class RadarControlButton;
class RadarControlItem {  // tells each change of its value
 public:
  std::string name;
  int value = -99999;
  RadarControlState state = RCS_OFF;
  RadarControlItem(std::string of = "other") : name(of) {}
  void Update(int v, RadarControlState s = RCS_MANUAL) {
    if ((v != value || s != state) && name != "other") Say(name, v), Say(name + "-state", s);
    value = v, state = s;
  }
  int GetValue() const { return value; }
  RadarControlState GetState() const { return state; }
};
struct Statistics { long packets = 0, broken_packets = 0, spokes = 0, missing_spokes = 0; };
class radar_pi {
 public:
  double GetHeadingTrue() { return 0.0; }
  wxLongLong GetBootMillis() { return 0; }
};
class RadarInfo {
 public:
  wxString m_name = "radar";
  wxCriticalSection m_exclusive;
  bool m_showManualValueInAuto, m_timed_idle_hardware;
  time_t m_radar_timeout, m_data_timeout;
  Statistics m_statistics;
  RadarControlItem m_state{"power"}, m_range{"range"}, m_gain{"gain"}, m_sea{"sea"}, m_rain{"rain"},
      m_interference_rejection{"rejection"}, m_scan_speed, m_bearing_alignment, m_timed_idle, m_timed_run, m_next_state_change,
      m_no_transmit_start[4], m_no_transmit_end[4];
  int m_no_transmit_zones = 0;
  NetworkAddress address, radar;
  unsigned char image[GARMIN_XHD_SPOKES][GARMIN_XHD_MAX_SPOKE_LEN] = {};
  int samples = 0, metres = 0;
  bool found = false;
  NetworkAddress GetRadarInterfaceAddress() { return address; }
  void DetectedRadar(NetworkAddress &of, NetworkAddress &from) { address = of, radar = from, found = true, Say("found", 1); }
  void resetTimeout(time_t now) { m_radar_timeout = now + WATCHDOG_TIMEOUT; }
  void ResetRadarImage() { Say("reset", 1); }
  void ProcessRadarSpoke(SpokeBearing angle, SpokeBearing, uint8_t *data, size_t count, int to, wxLongLong) {
    if (m_statistics.spokes == 1) Say("spoke", angle);
    memset(image[angle], 0, sizeof image[angle]);
    memcpy(image[angle], data, count), samples = count, metres = to;
  }
};
}  // namespace RadarPlugin
