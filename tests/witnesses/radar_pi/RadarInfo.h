// What the receiver and the control of radar_pi for a Garmin xHD or a Navico HALO take of the rest of the plug-in: it tells what they say, one
// line each, to standard output. A list made when it is built has the names of its controls.
#pragma once
#include "pi_common.h"
#include "socketutil.h"
#include "RadarLocationInfo.h"
#include <cmath>
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
#define IF_LOG_AT_LEVEL(level) if (false)
#define GARMIN_XHD_SPOKES 1440
#define GARMIN_XHD_MAX_SPOKE_LEN 705
#ifdef NAVICO
#define SPOKES 2048
#define SAMPLES 1024
#else
#define SPOKES 1440
#define SAMPLES 705
#endif
#define MOD_SPOKES(raw) (((raw) + 2 * SPOKES) % SPOKES)
#define MOD_DEGREES(angle) (((int)(angle) + 720) % 360)
#define MOD_DEGREES_FLOAT(angle) fmod((angle) + 720.0, 360.0)
#define MOD_DEGREES_180(angle) (((int)(angle) + 900) % 360 - 180)
#define M_SETTINGS m_pi->m_settings
#define MAX_REPORT 3
#define MAX(a, b) ((a) > (b) ? (a) : (b))
typedef int SpokeBearing;
enum RadarState { RADAR_OFF, RADAR_STANDBY, RADAR_WARMING_UP, RADAR_TIMED_IDLE, RADAR_STOPPING, RADAR_SPINNING_DOWN, RADAR_STARTING,
                  RADAR_SPINNING_UP, RADAR_TRANSMIT };
enum RadarControlState { RCS_OFF = -1, RCS_MANUAL, RCS_AUTO_1, RCS_AUTO_2 };
enum ControlType {
#include "items.h"
};
enum RadarType { RT_BR24, RT_3G, RT_4GA, RT_4GB, RT_HaloA, RT_HaloB, RT_MAX };
enum { RO_SINGLE, RO_PRIMARY, RO_SECONDARY };
const int RadarOrder[RT_MAX] = {RO_SINGLE, RO_SINGLE, RO_PRIMARY, RO_SECONDARY, RO_PRIMARY, RO_SECONDARY};
enum { HEADING_NONE, HEADING_FIX_COG, HEADING_RADAR_HDM = 7 };
class RadarControlButton;
class RadarControl;
class RadarInfo;
class NavicoLocate;
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
  bool IsModified() const { return false; }
};
struct Statistics { long packets = 0, broken_packets = 0, spokes = 0, missing_spokes = 0, broken_spokes = 0; };
class radar_pi {
 public:
  struct { size_t radar_count = 1; bool ignore_radar_heading = false; int verbose = 0; } m_settings;
  int m_heading_source = HEADING_NONE;
  RadarInfo *m_radar[1] = {};
  NavicoLocate *m_navico_locator = nullptr;
  double GetHeadingTrue() { return 0.0; }
  double GetCOG() { return 0.0; }
  double GetSOG() { return 0.0; }
  void SetRadarHeading(double = 0.0, bool = false) {}
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
      m_no_transmit_start[4], m_no_transmit_end[4], m_mode, m_target_boost, m_target_expansion, m_antenna_height, m_parking_angle,
      m_accent_light, m_antenna_size, m_sea_state, m_noise_rejection, m_target_separation, m_side_lobe_suppression,
      m_local_interference_rejection, m_doppler{"doppler"}, m_doppler_threshold;
  RadarType m_radar_type = RT_HaloA;
  RadarLocationInfo m_radar_location_info;
  RadarControl *m_control = nullptr;
  int m_radar = 0, m_stay_alive_type = 0, heading = 0;
  NetworkAddress m_radar_address;
  int m_no_transmit_zones = 0;
  NetworkAddress address, radar;
  unsigned char image[SPOKES][SAMPLES] = {};
  int samples = 0, metres = 0;
  bool found = false;
  NetworkAddress GetRadarInterfaceAddress() { return address; }
  void DetectedRadar(NetworkAddress &of, NetworkAddress &from) { address = of, radar = from, found = true, Say("found", 1); }
  RadarLocationInfo GetRadarLocationInfo() { return m_radar_location_info; }
  void SetRadarLocationInfo(const RadarLocationInfo &of) { m_radar_location_info = of; }
  void SetRadarInterfaceAddress(NetworkAddress &of, NetworkAddress &at) { address = of, m_radar_address = at; }
  void ComputeColourMap() {}
  void resetTimeout(time_t now) { m_radar_timeout = now + WATCHDOG_TIMEOUT; }
  void ResetRadarImage() { Say("reset", 1); }
  void ProcessRadarSpoke(SpokeBearing angle, SpokeBearing bearing, uint8_t *data, size_t count, int to, wxLongLong) {
    if (m_statistics.spokes == 1) Say("spoke", angle);
    memset(image[angle], 0, sizeof image[angle]);
    memcpy(image[angle], data, count), samples = count, metres = to, heading = MOD_SPOKES(bearing - angle);
  }
};
}  // namespace RadarPlugin
