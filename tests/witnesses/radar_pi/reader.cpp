// Runs the receiver and the control of radar_pi for a Garmin xHD or, with NAVICO, for a HALO. Words on standard input: on, off, range N, gain N, gain-auto,
// sea N, sea-auto, rain N, rejection N, image FILE, quit.
#ifdef NAVICO
#include "NavicoControl.h"
#include "NavicoReceive.h"
#define Control NavicoControl
#else
#include "GarminxHDControl.h"
#include "GarminxHDReceive.h"
#define Control GarminxHDControl
#endif
#include <wx/init.h>
#include <fstream>
#include <iostream>
using namespace RadarPlugin;
static bool Set(Control &control, ControlType type, int value, RadarControlState state = RCS_MANUAL) {
  RadarControlItem item;
  item.Update(value, state);
  return control.SetControlValue(type, item, nullptr);
}
int main() {
  wxInitializer wx;
  wxLog::SetLogLevel(0);
  radar_pi pi;
  static RadarInfo info;
#ifdef NAVICO
  pi.m_radar[0] = &info;
  NavicoReceive receive(&pi, &info, NetworkAddress(), NetworkAddress(), NetworkAddress());
  NavicoControl control(&pi, &info);
  info.m_control = &control;
  NavicoLocate locate(&pi);
  locate.Run();
#else
  GarminxHDReceive receive(&pi, &info, NetworkAddress(239, 254, 2, 0, 50100), NetworkAddress(239, 254, 2, 0, 50102));
  GarminxHDControl control(NetworkAddress(172, 16, 2, 0, 50101));
#endif
  receive.Run();
  Say("started", 1);
  bool is_open = false;
  for (std::string word; std::cin >> word && word != "quit";) {
    if (info.found && !is_open) is_open = control.Init(&pi, &info, info.address, info.radar);
    int value = 0;
    std::string name;
    if (word == "image") std::cin >> name;
    else if (word != "on" && word != "off" && word.find("auto") == std::string::npos) std::cin >> value;
    Say("say-" + word, value);
    if (word == "on") control.RadarTxOn();
    if (word == "off") control.RadarTxOff();
    if (word == "range") control.SetRange(value);
    if (word == "gain") Set(control, CT_GAIN, value);
    if (word == "gain-auto") Set(control, CT_GAIN, 0, RCS_AUTO_1);
    if (word == "sea") Set(control, CT_SEA, value);
    if (word == "sea-auto") Set(control, CT_SEA, 0, RCS_AUTO_1);
    if (word == "rain") Set(control, CT_RAIN, value);
    if (word == "rejection") Set(control, CT_INTERFERENCE_REJECTION, value);
    if (word == "image") {
      wxCriticalSectionLocker lock(info.m_exclusive);
      std::ofstream(name, std::ios::binary).write((const char *)info.image, sizeof info.image);
      Say("samples", info.samples), Say("metres", info.metres);
      Say("spokes", info.m_statistics.spokes), Say("missing", info.m_statistics.missing_spokes);
      Say("heading", info.heading);
      Say("broken", info.m_statistics.broken_packets);
    }
  }
  receive.Shutdown();
  receive.Wait();
#ifdef NAVICO
  locate.Shutdown();
  locate.Wait();
#endif
}
