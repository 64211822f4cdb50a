// Runs the locator, the controller and the parsers of mayara-core for a Navico HALO over sockets of 172.16.3.150. Words on standard
// input: a control and a value, as "gain 85" or "status 1", "image FILE", "quit 0"; says what changes, a line each.
use mayara_core::controllers::{NavicoController, NavicoModel};
use mayara_core::io::{IoError, IoProvider, TcpSocketHandle, UdpSocketHandle};
use mayara_core::protocol::navico;
use mayara_core::{Brand, LocatorEvent, RadarLocator};
use std::collections::HashMap;
use std::io::BufRead;
use std::net::{Ipv4Addr, UdpSocket};
use std::os::fd::{AsRawFd, FromRawFd};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const OWN: Ipv4Addr = Ipv4Addr::new(172, 16, 3, 150);
extern "C" {
    fn socket(domain: i32, kind: i32, protocol: i32) -> i32;
    fn setsockopt(socket: i32, level: i32, name: i32, value: *const i32, length: u32) -> i32;
    fn bind(socket: i32, address: *const u8, length: u32) -> i32;
}

fn failed<E: std::fmt::Display>(error: E) -> IoError {
    IoError::new(-1, error.to_string())
}

#[derive(Default)]
struct Sockets(HashMap<i32, UdpSocket>);

impl IoProvider for Sockets {
    fn udp_create(&mut self) -> Result<UdpSocketHandle, IoError> {
        let made = unsafe { UdpSocket::from_raw_fd(socket(2, 2, 0)) };
        let (number, own) = (made.as_raw_fd(), OWN.octets());
        unsafe {
            setsockopt(number, 1, 2, &1, 4); // SO_REUSEADDR
            setsockopt(number, 0, 32, own.as_ptr().cast(), 4); // IP_MULTICAST_IF
        }
        made.set_nonblocking(true).map_err(failed)?;
        self.0.insert(number, made);
        Ok(UdpSocketHandle(number))
    }
    fn udp_bind(&mut self, of: &UdpSocketHandle, port: u16) -> Result<(), IoError> {
        let mut address = [0u8; 16];
        address[..2].copy_from_slice(&2u16.to_ne_bytes());
        address[2..4].copy_from_slice(&port.to_be_bytes());
        match unsafe { bind(of.0, address.as_ptr(), 16) } {
            0 => Ok(()),
            _ => Err(failed(std::io::Error::last_os_error())),
        }
    }
    fn udp_set_broadcast(&mut self, of: &UdpSocketHandle, enabled: bool) -> Result<(), IoError> {
        self.0[&of.0].set_broadcast(enabled).map_err(failed)
    }
    fn udp_join_multicast(&mut self, of: &UdpSocketHandle, group: &str, _: &str) -> Result<(), IoError> {
        let group = group.parse().map_err(failed)?;
        self.0[&of.0].join_multicast_v4(&group, &OWN).map_err(failed)
    }
    fn udp_send_to(&mut self, of: &UdpSocketHandle, data: &[u8], to: &str, port: u16) -> Result<usize, IoError> {
        self.0[&of.0].send_to(data, (to, port)).map_err(failed)
    }
    fn udp_recv_from(&mut self, of: &UdpSocketHandle, room: &mut [u8]) -> Option<(usize, String, u16)> {
        let (length, from) = self.0[&of.0].recv_from(room).ok()?;
        Some((length, from.ip().to_string(), from.port()))
    }
    fn udp_pending(&self, _: &UdpSocketHandle) -> i32 { -1 }
    fn udp_close(&mut self, of: UdpSocketHandle) { self.0.remove(&of.0); }
    fn tcp_create(&mut self) -> Result<TcpSocketHandle, IoError> { Err(failed("no TCP")) }
    fn tcp_connect(&mut self, _: &TcpSocketHandle, _: &str, _: u16) -> Result<(), IoError> { Err(failed("no TCP")) }
    fn tcp_is_connected(&self, _: &TcpSocketHandle) -> bool { false }
    fn tcp_is_valid(&self, _: &TcpSocketHandle) -> bool { false }
    fn tcp_set_line_buffering(&mut self, _: &TcpSocketHandle, _: bool) -> Result<(), IoError> { Err(failed("no TCP")) }
    fn tcp_send(&mut self, _: &TcpSocketHandle, _: &[u8]) -> Result<usize, IoError> { Err(failed("no TCP")) }
    fn tcp_recv_line(&mut self, _: &TcpSocketHandle, _: &mut [u8]) -> Option<usize> { None }
    fn tcp_recv_raw(&mut self, _: &TcpSocketHandle, _: &mut [u8]) -> Option<usize> { None }
    fn tcp_pending(&self, _: &TcpSocketHandle) -> i32 { 0 }
    fn tcp_close(&mut self, _: TcpSocketHandle) {}
    fn current_time_ms(&self) -> u64 { (1000.0 * now()) as u64 }
    fn debug(&self, text: &str) { eprintln!("{text}") }
    fn info(&self, text: &str) { eprintln!("{text}") }
}

fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64()
}

#[derive(Default)]
struct Said(HashMap<String, String>);

impl Said {
    fn say(&mut self, what: &str, value: impl ToString) {
        let value = value.to_string();
        if self.0.get(what) != Some(&value) {
            println!("{:.4} {what} {value}", now());
            self.0.insert(what.to_string(), value);
        }
    }
    fn report(&mut self, data: &[u8]) {
        if let Ok(status) = navico::parse_report_01(data) {
            self.say("status", status as u8);
        } else if let Ok(controls) = navico::parse_report_02(data) {
            self.say("range", controls.range);
            self.say("gain", if controls.gain_auto { -1 } else { i32::from(controls.gain) });
            self.say("rain", controls.rain);
            self.say("sea-auto", controls.sea_auto);
            self.say("rejection", controls.interference_rejection);
        } else if let Ok(settings) = navico::parse_report_08(data) {
            self.say("sea", settings.sea_clutter);
        }
    }
}

fn joined(io: &mut Sockets, address: &str) -> UdpSocketHandle {
    let (group, port) = address.split_once(':').unwrap();
    let made = io.udp_create().unwrap();
    io.udp_bind(&made, port.parse().unwrap()).unwrap();
    io.udp_join_multicast(&made, group, "").unwrap();
    made
}

fn main() {
    let (mut io, mut locator, mut said) = (Sockets::default(), RadarLocator::new(), Said::default());
    said.say("started", 1);
    locator.start(&mut io);
    let radar = 'found: loop {
        for event in locator.poll(&mut io) {
            if let LocatorEvent::RadarDiscovered(radar) = event {
                if radar.brand == Brand::Navico {
                    break 'found radar;
                }
            }
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    said.say("found", 1);
    let (report, send) = (radar.report_address.clone().unwrap(), radar.send_address.clone().unwrap());
    let part = |of: &str| -> (String, u16) { let (a, p) = of.split_once(':').unwrap(); (a.to_string(), p.parse().unwrap()) };
    let (to, from) = (part(&send), part(&report));
    let mut control = NavicoController::new("radar", &to.0, to.1, &from.0, from.1, &OWN.to_string(), NavicoModel::Halo);
    let (reports, video) = (joined(&mut io, &report), joined(&mut io, radar.data_address.as_deref().unwrap()));
    let (words, mut image, mut metres) = (std::sync::mpsc::channel::<String>(), vec![0u8; 2048 * 1024], 0);
    let (sender, receiver) = words;
    std::thread::spawn(move || std::io::stdin().lock().lines().for_each(|line| sender.send(line.unwrap()).unwrap()));
    let mut room = [0u8; 65536];
    let (mut broken, mut polled) = (0, 0.0);
    loop {
        if now() - polled > 0.1 {
            polled = now();
            control.poll(&mut io);
        }
        while let Some((length, _, _)) = io.udp_recv_from(&reports, &mut room) {
            said.report(&room[..length]);
        }
        while let Some((length, _, _)) = io.udp_recv_from(&video, &mut room) {
            for line in room[navico::FRAME_HEADER_SIZE..length].chunks(navico::SPOKE_LINE_SIZE) {
                let (range, angle, heading) = match navico::parse_4g_spoke_header(line) {
                    Ok(of) => of,
                    Err(_) => {
                        broken += 1;
                        continue;
                    }
                };
                if metres == 0 {
                    said.say("spoke", angle);
                    said.say("heading", heading.map_or(-1, |of| i32::from(of) / 2));
                }
                metres = range;
                let begin = 1024 * usize::from(angle);
                image[begin..begin + 1024].copy_from_slice(&navico::unpack_spoke_data(&line[navico::SPOKE_HEADER_SIZE..]));
            }
        }
        while let Ok(line) = receiver.try_recv() {
            let (word, value) = line.split_once(' ').unwrap();
            said.say(&format!("say-{word}"), value);
            let number = value.parse::<i32>().unwrap_or(0);
            match word {
                "range" => control.set_range(&mut io, number),
                "gain" => control.set_gain(&mut io, number.max(0) as u8, number < 0),
                "sea" => control.set_sea(&mut io, number.max(0) as u8, number < 0),
                "rain" => control.set_rain(&mut io, number as u8),
                "rejection" => control.set_interference_rejection(&mut io, number as u8),
                "status" => control.set_power(&mut io, number == 2),
                "image" => {
                    std::fs::write(value, &image).unwrap();
                    said.say("samples", 1024);
                    said.say("metres", metres);
                    said.say("broken", broken);
                }
                _ => return,
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
