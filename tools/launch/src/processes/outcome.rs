//! The outcome of a run: a summary of what its processes report, and of what the dead ones left.

use slipstream_agents::process::AgentOutcome;
use slipstream_bus::experiment::Clock;
use slipstream_bus::message::robot_name;
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_hosts::hello::RemoteHost;
use slipstream_hosts::stand_in::StandInOutcome;
use slipstream_ipc::clock::Deadlines;
use slipstream_ipc::report;
use slipstream_robots::process::RobotsOutcome;
use slipstream_sim::run::process::PlantOutcome;

use super::launcher::Run;
use super::options::Options;
use super::state_transfer;
use crate::role::Role;
use crate::summary::{DeadlineSummary, Process, ProcessReports, RunStatus, RunSummary};

impl Run<'_> {
    /// Assembles the summary from the final reports of the processes.
    pub(super) fn summarise(&mut self, options: &Options) -> RunSummary {
        let settings = &self.experiment.settings;
        let robots = settings.robots.count;
        let plant: Option<PlantOutcome> =
            report::read(self.directory.folder(), &Role::Plant.name());
        let agents: Vec<Option<AgentOutcome>> = (0..robots)
            .map(|robot| report::read(self.directory.folder(), &robot_name(robot)))
            .collect();
        let reports = ProcessReports {
            plant: plant.as_ref().map(|plant| plant.report.clone()),
            agents: agents
                .iter()
                .map(|agent| agent.as_ref().map(|a| a.report.clone()))
                .collect(),
        };
        let mut summary = RunSummary::new(self.experiment, &reports);
        summary.processes = std::mem::take(&mut self.processes);
        summary.processes.extend(self.processes_elsewhere(options));
        summary.recording = options.out.clone().filter(|out| out.exists());
        summary.status = self.status.clone();
        if plant.is_none() {
            summary.duration_s = s_from_ns(self.wake_page.progress().0);
        }
        summary.add_timing(plant.as_ref(), &agents);
        let robots: Option<RobotsOutcome> =
            report::read(self.directory.folder(), &Role::Robots.name());
        if let Some(robots) = &robots {
            summary.add_real(robots);
        }
        if settings.clock == Clock::Wall {
            summary.deadlines = self.deadlines(plant.as_ref(), &agents, summary.duration_s);
        }
        if let Some(elsewhere) = self.elsewhere() {
            // A chunk holds many records; one is sure.
            summary.lost_records += elsewhere.lost_chunks;
            // Said when it happened.
            let failure = elsewhere.failures.into_iter().next();
            if let Some(failure) = failure.filter(|_| self.status == RunStatus::Done) {
                self.status = RunStatus::Failed(failure);
                summary.status = self.status.clone();
            }
        }
        if summary.lost_records > 0 && self.status == RunStatus::Done {
            let lost = summary.lost_records;
            self.fail(format!(
                "{lost} records are missing from the recording: the recorder was held up; record \
                 to a faster disk, or free a core"
            ));
            summary.status = self.status.clone();
        }
        summary
    }

    /// What the stand-in for other hosts reports, if there is one.
    fn elsewhere(&self) -> Option<StandInOutcome> {
        report::read(self.directory.folder(), &Role::StandIn(0).name())
    }

    /// The agents on other hosts.
    fn processes_elsewhere(&self, options: &Options) -> Vec<Process> {
        let folder = self.directory.folder();
        let hosts = options.across.iter().flat_map(|across| &across.hosts);
        let robots = hosts.flat_map(|host| host.robots.iter().map(move |&robot| (host, robot)));
        let process = |(host, robot): (&RemoteHost, _)| {
            let pid = state_transfer::pid(folder, robot)?;
            Some(Process::on_host(&host.name, robot, pid))
        };
        robots.filter_map(process).collect()
    }

    /// The deadline counts of the loops of plant and agents: what they report, or, of those that left
    /// no report, what they had counted, with what was due until the end of the run as missed.
    fn deadlines(
        &self,
        plant: Option<&PlantOutcome>,
        agents: &[Option<AgentOutcome>],
        end_s: f64,
    ) -> Vec<DeadlineSummary> {
        let settings = &self.experiment.settings;
        let schedule = settings.schedule();
        let step = ("step", ns_from_s(settings.plant.step_s));
        let loops = [("outer", schedule.outer_ns), ("inner", schedule.inner_ns)];
        let reported = plant.and_then(|plant| plant.deadlines);
        let mut all = match self.part.is_real() {
            true => Vec::new(),
            false => self.loops_of(Role::Plant, &[step], reported.map(|step| vec![step]), end_s),
        };
        for (role, agent) in (0..).map(Role::Agent).zip(agents) {
            let reported = agent.as_ref().and_then(|agent| agent.deadlines);
            all.extend(self.loops_of(role, &loops, reported.map(Vec::from), end_s));
        }
        all
    }

    /// The deadline counts of the loops of one process, each with its name and period (ns).
    fn loops_of(
        &self,
        role: Role,
        loops: &[(&'static str, i64)],
        reported: Option<Vec<Deadlines>>,
        end_s: f64,
    ) -> Vec<DeadlineSummary> {
        let left = || {
            let counts = self.wake_page.deadlines(role.member()).into_iter();
            let restored = counts.zip(loops).map(|(counts, &(name, period_ns))| {
                Deadlines::from_shared(name, counts, ns_from_s(end_s), period_ns)
            });
            restored.collect()
        };
        let counts = reported.unwrap_or_else(left);
        let summaries = loops.iter().zip(&counts);
        summaries
            .map(|((name, _), counts)| DeadlineSummary::new(&role.name(), name, counts))
            .collect()
    }
}
