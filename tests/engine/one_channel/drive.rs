//! Three drives: lively and calm ones that are simulated, and a real one.

use gripd::can::candump::Reader;
use gripd::model::{Reading, Scenario, Simulation};
use gripd::service::Engine;
use gripd::{Config, Estimates, Quantity};
use testing::heard::Heard;
use testing::{demo_car as car, program};

pub struct Drive {
    pub name: &'static str,
    pub readings: Vec<Reading>,
    config: Config,
}

/// Steering (rad, rms) and its correlation time, s; variation of the speed, m/s rms.
fn scenario(duration_s: f64, steering: (f64, f64), speed: f64) -> Scenario {
    let text = std::fs::read_to_string(program::project("config/scenarios/demo.toml")).unwrap();
    let mut table: toml::Table = text.parse().unwrap();
    let course = format!(
        "driver = {{ speed_mps = [{{ kind = \"points\", points = [[0, 15], [8, 17]] }}, \
           {{ kind = \"random\", rms = {speed}, correlation_time_s = 4.0 }}] }}\n\
         steering_wheel_angle = [{{ kind = \"random\", rms = {}, correlation_time_s = {} }}]",
        steering.0, steering.1
    );
    table.extend(course.parse::<toml::Table>().unwrap());
    table["road"].as_array_mut().unwrap().truncate(1);
    table.remove("brake_pressure");
    table.insert("duration_s".into(), duration_s.into());
    Scenario::parse(&toml::to_string(&table).unwrap()).unwrap()
}

impl Drive {
    /// Curves of 3 m/s² (rms), and much accelerating and braking.
    pub fn lively(duration_s: f64) -> Self {
        Self::simulated("lively", &scenario(duration_s, (0.5, 1.5), 3.0))
    }

    pub fn calm(duration_s: f64) -> Self {
        Self::simulated("calm", &scenario(duration_s, (0.15, 2.0), 1.0))
    }

    fn simulated(name: &'static str, scenario: &Scenario) -> Self {
        let mut simulation = Simulation::new(scenario, 1).unwrap();
        let mut readings = Vec::new();
        while let Some(tick) = simulation.next_tick() {
            readings.extend_from_slice(tick.readings);
        }
        Self { name, readings, config: car::config() }
    }

    /// Circles of a Golf GTI, where the shared recordings are there.
    pub fn gti() -> Option<Self> {
        let folder = testing::shared("recordings")?;
        let mut config = Config::load(&folder.join("gti/drives.toml")).unwrap();
        config.signals.sampling.rate_watch = false;
        let mut engine = Engine::new(&config).unwrap();
        let mut heard = Heard::default();
        let mut reader = Reader::open(&folder.join("gti/group1controller.log.gz")).unwrap();
        while let Some(frame) = reader.next_frame().unwrap() {
            engine.frame(&frame, &mut heard);
        }
        engine.finish(&mut heard);
        let of = |sample: &gripd::Sample| {
            let time = sample.time;
            Quantity::ALL.map(|quantity| sample.get(quantity).map(|value| Reading { time, quantity, value }))
        };
        let readings = heard.samples.iter().flat_map(of).flatten().collect();
        Some(Self { name: "GTI", readings, config })
    }

    /// What comes out where the sensors say this.
    pub fn run(&self, readings: &[Reading]) -> Vec<Estimates> {
        let mut engine = car::engine(&self.config);
        let mut heard = Heard::default();
        car::frames_of(&self.config, readings).iter().for_each(|frame| engine.frame(frame, &mut heard));
        engine.finish(&mut heard);
        heard.estimates
    }
}
