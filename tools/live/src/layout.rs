//! A Foxglove layout: the floor with all robots, speeds, slip, and what went wrong.

use serde_json::{Value, json};

/// Robots that are plotted.
const PLOTTED: usize = 6;

/// The layout for these robots, as the JSON that Foxglove imports.
pub fn layout(robots: &[&str]) -> Value {
    let plotted = robots.iter().take(PLOTTED);
    let path = |value: String, label: String| json!({"timestampMethod": "headerStamp", "value": value, "label": label, "enabled": true});
    let speeds: Vec<Value> = plotted
        .clone()
        .map(|robot| {
            path(
                format!("/{robot}/odometry.twist.twist.linear.x"),
                format!("{robot} by its wheels, m/s"),
            )
        })
        .collect();
    let slips: Vec<Value> = plotted
        .clone()
        .flat_map(|robot| {
            ["right", "left"].map(|side| {
                path(
                    format!("/{robot}/contact.{side}.slip_longitudinal_m_s"),
                    format!("{robot} {side}, m/s"),
                )
            })
        })
        .collect();
    let places: Vec<Value> = plotted
        .map(|robot| {
            path(
                format!("/{robot}/pose.pose.position.x"),
                format!("{robot} x, m"),
            )
        })
        .collect();
    let plot = |title: &str, paths: Vec<Value>| {
        json!({"title": title, "paths": paths, "showXAxisLabels": true, "showYAxisLabels": true, "showLegend": true,
            "legendDisplay": "floating", "isSynced": true, "xAxisVal": "timestamp", "followingViewWidth": 20})
    };
    json!({
        "configById": {
            "3D!floor": {
                "cameraState": {"perspective": false, "distance": 8, "phi": 0, "thetaOffset": 90, "targetOffset": [2, 0, 0], "target": [0, 0, 0]},
                "followMode": "follow-none", "followTf": "world",
                "layers": {"grid": {"layerId": "foxglove.Grid", "label": "Grid", "visible": true, "size": 20, "divisions": 20}},
                "scene": {"transforms": {"editable": false}}, "topics": {}, "transforms": {},
            },
            "Plot!speed": plot("Speed by the wheels", speeds),
            "Plot!slip": plot("Slip of each wheel", slips),
            "Plot!place": plot("Place as the camera sees it", places),
            "RawMessages!events": {"topicPath": "/events", "diffEnabled": false, "expansion": "auto"},
        },
        "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": {
            "direction": "row", "splitPercentage": 45,
            "first": {"direction": "column", "splitPercentage": 75, "first": "3D!floor", "second": "RawMessages!events"},
            "second": {"direction": "column", "first": "Plot!speed", "second": {"direction": "column", "first": "Plot!slip", "second": "Plot!place"}},
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_of_the_layout_is_configured() {
        let layout = layout(&["r1", "r2"]);
        let panels = layout["configById"].as_object().unwrap();
        let mut shown = Vec::new();
        collect(&layout["layout"], &mut shown);
        assert_eq!(shown.len(), panels.len());
        assert!(shown.iter().all(|id| panels.contains_key(id)));
        assert_eq!(
            layout["configById"]["Plot!slip"]["paths"]
                .as_array()
                .unwrap()
                .len(),
            4
        );
    }

    fn collect(node: &Value, into: &mut Vec<String>) {
        match node {
            Value::String(id) => into.push(id.clone()),
            other => ["first", "second"]
                .iter()
                .for_each(|own| collect(&other[own], into)),
        }
    }
}
